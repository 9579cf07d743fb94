// The stiffest walls that simulated arms hold still, as docs/stability.md has them, and what is stiffer in a scene.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::host {

inline constexpr std::array<double, 3> kStableRates_Hz = {1000, 4000, 10000};
inline constexpr std::array<double, 4> kStableDampings_N_s_m = {0, 1, 2, 5};

// N/m, a row a damping: the lesser of the tables for the two hands.
struct StableStiffness {
  std::string_view arm;
  std::array<std::array<double, kStableRates_Hz.size()>, kStableDampings_N_s_m.size()> most_N_m;
};
[[nodiscard]] std::span<const StableStiffness> stable_stiffness();

// A wall that an arm holds still.
struct HeldWall {
  double rate_Hz, damping_N_s_m, stiffness_N_m;
};

// What is known of an arm; without walls: nothing.
struct ArmWalls {
  std::string arm;
  std::vector<HeldWall> walls;
  std::string source = "docs/stability.md";  // as warnings have it
};

// Of the tables.
[[nodiscard]] ArmWalls known_walls(std::string_view arm);

// Linear between the dampings of a rate, and between the rates. Below the rates in proportion to the rate; above them, and outside of
// the dampings, as at the end. None without walls, or for a rate of 0.
[[nodiscard]] std::optional<double> stable_stiffness_N_m(std::span<const HeldWall> walls, double rate_Hz,
                                                         double damping_N_s_m);
[[nodiscard]] std::optional<double> stable_stiffness_N_m(std::string_view arm, double rate_Hz,
                                                         double damping_N_s_m);

// A warning for each object of a scene image that is stiffer, or damped more than is known, with the figures; also for its
// stiffness map. Each one once. Potential fields have no stiffness of their own. No warning for an image that is not valid.
[[nodiscard]] std::vector<std::string> stiffness_warnings(std::span<const std::byte> image,
                                                          std::span<const ArmWalls> arms, double rate_Hz);
// By the tables. arms: names with commas between them, as a device has them.
[[nodiscard]] std::vector<std::string> stiffness_warnings(std::span<const std::byte> image,
                                                          std::string_view arms, double rate_Hz);

// "premium-1.5,wooden" by its commas.
[[nodiscard]] std::vector<std::string> names_of_arms(std::string_view arms);

}  // namespace thimble::host
