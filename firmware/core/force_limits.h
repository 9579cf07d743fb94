// The force limits of one arm: vector clamp and slew limit. Called every tick. A limit says whether it acted;
// neither turns the vector it limits (the clamp keeps the force's direction, the slew limit the direction of
// its change).
//
// Expects finite vectors; cannot fail. Units: N.
#pragma once

#include <cmath>

#include "kinematics/limited.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

using LimitedForce = kinematics::Limited<Vec3, bool>;

[[nodiscard]] inline LimitedForce clamp_force(const Vec3& force_N, float max_N) noexcept {
  const float norm = std::sqrt(force_N.squaredNorm());
  if (!(norm > max_N)) return {force_N, false};
  return {force_N * (max_N / norm), true};
}

[[nodiscard]] inline LimitedForce slew_force(const Vec3& force_N, const Vec3& last_N,
                                             float max_step_N) noexcept {
  const LimitedForce step = clamp_force(force_N - last_N, max_step_N);
  if (!step.which) return {force_N, false};
  return {last_N + step.value, true};
}

}  // namespace thimble::firmware
