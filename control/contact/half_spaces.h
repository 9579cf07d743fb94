// The point of an intersection of half-spaces that is nearest to a given point (Zilles and Salisbury 1995, with
// any number of planes).
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "control/work.h"
#include "kinematics/vector.h"

namespace thimble::control {

// normal . p >= offset_m, with a unit normal.
struct HalfSpace {
  Vec3 normal;
  float offset_m;

  [[nodiscard]] float height_m(const Vec3& p) const { return normal.dot(p) - offset_m; }
};

inline constexpr float kSettled_m = 5.0e-8F;   // a step below this is rounding
inline constexpr std::size_t kMaxHolding = 3;  // planes that hold a point in space

// point = target + sum of lambda_m[i] normal[holding[i]], every lambda_m >= 0.
struct NearestInside {
  Vec3 point_m = Vec3::Zero();
  std::array<std::size_t, kMaxHolding> holding{};
  Vec3 lambda_m = Vec3::Zero();
  std::size_t count = 0;
  bool found =
      true;  // false: the bound was hit, or nearly parallel planes leave no answer; point_m is not to be used
};

// At most kMaxRounds planes are taken in, the most violated one first, as long as there is work; each time at most seven sets of three
// planes are tried. The point may lie behind a plane by rounding: kSettled_m and 2e-6 of the target's length.
[[nodiscard]] NearestInside nearest_inside(std::span<const HalfSpace> planes, const Vec3& target,
                                           Work& work) noexcept;

}  // namespace thimble::control
