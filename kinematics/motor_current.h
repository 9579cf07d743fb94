// Torques of the axes to motor currents, clamped to the limits of the motors. The firmware calls it in every tick
// as the last step before its outputs. If one motor would exceed its limit, all currents are scaled by
// the same factor, so the torque keeps its direction in joint space. Cannot fail; NaN input gives NaN output
// and no limit: the tick checks for finite values before the call.
#pragma once

#include <cstddef>

#include "kinematics/arm_data.h"

namespace thimble::kinematics {

inline constexpr int kNoAxis = -1;

struct MotorCurrents {
  PerAxis<float> current_A = PerAxis<float>::Zero();  // 0 for an axis without a motor
  int limited_by = kNoAxis;
};

// limit_A: per motor; below the peak current when derated by the thermal model.
[[nodiscard]] inline MotorCurrents motor_currents(const ArmData& arm, const PerAxis<float>& torque_N_m,
                                                  const PerAxis<float>& limit_A) noexcept {
  MotorCurrents found;
  const int axes = axes_of(arm.geometry);
  float excess = 1.0F;
  for (int j = 0; j < axes; ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (!arm.geometry.driven[at]) continue;
    float& current_A = found.current_A[j];
    current_A = torque_N_m[j] / arm.axis[at].torque_per_ampere();
    const float magnitude = current_A < 0 ? -current_A : current_A;
    if (magnitude > excess * limit_A[j]) {
      excess = limit_A[j] > 0 ? magnitude / limit_A[j] : 3.0e38F;
      found.limited_by = j;
    }
  }
  if (found.limited_by == kNoAxis) return found;
  for (int j = 0; j < axes; ++j) {
    // Clamp again: the division may round to above the limit.
    const float scaled = found.current_A[j] / excess;
    found.current_A[j] = scaled > limit_A[j] ? limit_A[j] : scaled < -limit_A[j] ? -limit_A[j] : scaled;
  }
  return found;
}

[[nodiscard]] inline MotorCurrents motor_currents(const ArmData& arm,
                                                  const PerAxis<float>& torque_N_m) noexcept {
  PerAxis<float> peak_A = PerAxis<float>::Zero();
  for (std::size_t j = 0; j < arm.axis.size(); ++j)
    peak_A[static_cast<int>(j)] = arm.axis[j].motor.peak_current_A;
  return motor_currents(arm, torque_N_m, peak_A);
}

}  // namespace thimble::kinematics
