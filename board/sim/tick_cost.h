// What a tick takes on a board's core, estimated from what its renderer has done: for a desk without the board (docs/time.md).
//
// A sum of terms with constants for each core. tests/hardware/cortex/fit_cost finds them from the exact counts of the emulated boards, and
// the tests cortex.replay.* compare the two.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "control/renderer.h"

namespace thimble::board {

// Each has a number of instructions.
struct TickTerms {
  static constexpr std::size_t kCount = 11;
  // One; arms but the first; arms that touch; contacts; arms that touch in a scene with shaded meshes; units of fingertips; units of bodies;
  // bodies awake; solids, volumes, and readings in the window of a velocity estimate, each times the arms.
  std::array<double, kCount> of{};
};
// touching, contacts: sums over the arms.
[[nodiscard]] TickTerms terms_of(const control::Renderer::Load& load, float period_s, std::size_t arms,
                                 std::size_t touching, std::size_t contacts) noexcept;

struct BoardCost {
  std::string_view name;  // as the board calls itself: Config::board
  std::string_view core;  // empty: it has none of its own, and only units are known
  double clock_Hz;        // an instruction a cycle is counted with
  std::array<double, TickTerms::kCount> instructions;

  [[nodiscard]] double of(const TickTerms& terms) const noexcept;
  // The most of some ticks, from the most of their estimates: it has to hold also for the ticks in which a unit takes more than on average.
  [[nodiscard]] static double worst(double most) noexcept;
  [[nodiscard]] std::uint32_t work_units(double rate_Hz,
                                         std::size_t arms = 1) const noexcept;  // Config::work_units
};
[[nodiscard]] std::span<const BoardCost> board_costs() noexcept;
[[nodiscard]] const BoardCost* find_board_cost(std::string_view name) noexcept;  // null: there is none

}  // namespace thimble::board
