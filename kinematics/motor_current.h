// Torques of the axes to motor currents, clamped to the limits of the motors. The firmware calls it in every tick
// as the last step before its outputs. If one motor would exceed its limit, all currents are scaled by
// the same factor, so the torque keeps its direction in joint space. Cannot fail; NaN input gives NaN output
// and no limit: the tick checks for finite values before the call.
#pragma once

#include <cmath>
#include <cstddef>

#include "kinematics/arm_data.h"

namespace thimble::kinematics {

inline constexpr int kNoAxis = -1;

// The axis whose motor limits them all, or kNoAxis. limit_A: per motor; below the peak current when derated by the thermal model. current_A: of
// the arm's axes, 0 where there is no motor; the others stay.
[[nodiscard]] inline int motor_currents(const ArmData& arm, int axes, const PerAxis<float>& torque_N_m,
                                        const PerAxis<float>& limit_A, PerAxis<float>& current_A) noexcept {
  float excess = 1.0F;
  int limited_by = kNoAxis;
  for (int j = 0; j < axes; ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (!arm.geometry.driven[at]) {
      current_A[j] = 0;
      continue;
    }
    const float asked_A = torque_N_m[j] / arm.axis[at].torque_per_ampere();
    current_A[j] = asked_A;
    const float magnitude = std::abs(asked_A);
    if (magnitude > excess * limit_A[j]) {
      excess = limit_A[j] > 0 ? magnitude / limit_A[j] : 3.0e38F;
      limited_by = j;
    }
  }
  if (limited_by == kNoAxis) return kNoAxis;
  for (int j = 0; j < axes; ++j) {
    if (!arm.geometry.driven[static_cast<std::size_t>(j)]) continue;
    // Clamp again: the division may round to above the limit.
    const float scaled = current_A[j] / excess;
    current_A[j] = scaled > limit_A[j] ? limit_A[j] : scaled < -limit_A[j] ? -limit_A[j] : scaled;
  }
  return limited_by;
}

}  // namespace thimble::kinematics
