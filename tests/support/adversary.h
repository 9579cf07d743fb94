// Fingertips that no hand moves like: for the most that a tick can cost.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace thimble::test {

enum class Attack : std::uint8_t {
  kSwing,     // straight through the middle, from side to side, at 0.94 m/s
  kTeleport,  // somewhere else every 20 ticks
  kPress,     // half of the radius deep, about the middle at 0.15 m/s; out and in again after 2000 ticks
  kDart,      // fast for some ticks, slow for others, to and fro
};
inline constexpr std::array<Attack, 4> kAttacks = {Attack::kSwing, Attack::kTeleport, Attack::kPress,
                                                   Attack::kDart};
inline constexpr std::array<const char*, 4> kAttackNames = {"swing", "teleport", "press", "dart"};

// Tick by tick at 4 kHz, about the origin, of which everything is within radius_m. The same seed gives the same path.
[[nodiscard]] std::vector<Eigen::Vector3d> attack_path(Attack attack, double radius_m, std::size_t ticks,
                                                       std::uint64_t seed);

}  // namespace thimble::test
