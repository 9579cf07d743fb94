// Joint torques to motor currents, clamped to the limits of the motors. The firmware calls it in every tick
// as the last step before its outputs. If one motor would exceed its limit, all three currents are scaled by
// the same factor, so the torque keeps its direction in joint space. Cannot fail; NaN input gives NaN output
// and kNone: the tick checks for finite values before the call.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "kinematics/arm_model.h"
#include "kinematics/limited.h"

namespace thimble::kinematics {

enum class CurrentLimit : std::uint8_t { kNone, kMotor1, kMotor2, kMotor3 };

// limit_A: per motor; below the peak current when derated by the thermal model.
[[nodiscard]] inline Limited<Eigen::Vector3f, CurrentLimit> motor_currents(
    const ArmModel& model, const Eigen::Vector3f& joint_torque_N_m, const Eigen::Vector3f& limit_A) noexcept {
  Eigen::Vector3f current_A;
  float excess = 1.0F;
  CurrentLimit which = CurrentLimit::kNone;
  for (int j = 0; j < 3; ++j) {
    current_A[j] = joint_torque_N_m[j] / model.torque_per_ampere(j);
    const float magnitude = current_A[j] < 0 ? -current_A[j] : current_A[j];
    if (magnitude > excess * limit_A[j]) {
      excess = limit_A[j] > 0 ? magnitude / limit_A[j] : 3.0e38F;
      which = static_cast<CurrentLimit>(j + 1);
    }
  }
  if (which != CurrentLimit::kNone) {
    for (int j = 0; j < 3; ++j) {
      // Clamp again: the division may round to above the limit.
      const float scaled = current_A[j] / excess;
      current_A[j] = scaled > limit_A[j] ? limit_A[j] : scaled < -limit_A[j] ? -limit_A[j] : scaled;
    }
  }
  return {current_A, which};
}

[[nodiscard]] inline Limited<Eigen::Vector3f, CurrentLimit> motor_currents(
    const ArmModel& model, const Eigen::Vector3f& joint_torque_N_m) noexcept {
  return motor_currents(model, joint_torque_N_m, Eigen::Vector3f::Constant(model.motor.peak_current_A));
}

}  // namespace thimble::kinematics
