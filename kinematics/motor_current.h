// Joint torques -> motor currents, clamped to what the motors take. The firmware calls it every tick as the
// last step before its outputs. When one motor would exceed its peak all three are scaled alike, so that the
// torque keeps its direction in joint space. Cannot fail; NaN in gives NaN out (and kNone): the tick's finite
// check stands before it.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "kinematics/arm_model.h"
#include "kinematics/limited.h"

namespace thimble::kinematics {

enum class CurrentLimit : std::uint8_t { kNone, kMotor1, kMotor2, kMotor3 };

// limit_A: per motor, for a limit below the peak (thermal derating).
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
      // The last min(): the division may round up past the limit.
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
