#include <algorithm>
#include <cmath>

#include "firmware/core/steps.h"
#include "kinematics/arm.h"
#include "kinematics/motor_current.h"

namespace thimble::firmware {
namespace {

// Force to torque to currents. False: one is not finite.
bool drive_arm(const Parts& parts, const kinematics::Arm<float>& geometry, ArmState& arm) noexcept {
  const kinematics::ArmData& data = geometry.data();
  const int axes = geometry.axes();
  arm.torque_N_m = kinematics::torques(arm.posture.jacobian, arm.force_N, axes);
  if (parts.params.on(Param::gravity_compensation))
    arm.torque_N_m += parts.state.gravity_ramp * geometry.gravity_torques(arm.posture);
  for (int j = 0; j < axes; ++j)
    if (!geometry.is_driven(j)) arm.torque_N_m[j] = 0;
  if (!finite(arm.torque_N_m)) return false;
  // A joint gets nothing of what a probe takes from another one.
  const bool probed = parts.state.mode == Mode::kArmed && arm.probe.probes();
  if (probed) {
    arm.force_N *= arm.given;
    arm.torque_N_m *= arm.given;
  }
  const float ambient_C = parts.params.get(Param::ambient);
  const float winding_limit_C = parts.params.get(Param::winding_limit);
  Axes limit_A = Axes::Zero();
  bool derated = false;
  for (std::size_t j = 0; j < arm.axes; ++j) {
    if (!geometry.is_driven(static_cast<int>(j))) continue;
    const kinematics::MotorModel& motor = data.axis[j].motor;
    const float allowed = arm.heat[j].allowed(ambient_C, std::min(winding_limit_C, motor.max_winding_C));
    limit_A[static_cast<int>(j)] = allowed * motor.peak_current_A;
    derated = derated || allowed < 1.0F;
  }
  const kinematics::MotorCurrents currents = kinematics::motor_currents(data, arm.torque_N_m, limit_A);
  if (!finite(currents.current_A)) return false;
  arm.current_A = currents.current_A;
  if (!probed) arm.given = 1;
  if (currents.limited_by == kinematics::kNoAxis) return true;
  // All torques were scaled alike, so the force was too.
  const int limiting = currents.limited_by;
  const kinematics::AxisData& axis = data.axis[static_cast<std::size_t>(limiting)];
  const float wanted_A = arm.torque_N_m[limiting] / axis.torque_per_ampere();
  const float scale = currents.current_A[limiting] / wanted_A;
  arm.force_N *= scale;
  arm.torque_N_m *= scale;
  if (!probed) arm.given = scale;
  arm.limiters |= derated && limit_A[limiting] < axis.motor.peak_current_A ? kLimitThermal : kLimitCurrent;
  return true;
}

}  // namespace

void drive(Parts& parts, Outputs& outputs) noexcept {
  State& state = parts.state;
  for (std::size_t i = 0; i < parts.setup.arm_count && motors_on(state.mode); ++i) {
    if (drive_arm(parts, parts.setup.arm[i], state.arm[i])) continue;
    trip(parts, Fault::torque_not_finite);
    break;
  }
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    if (motors_on(state.mode)) {
      for (std::size_t j = 0; j < arm.axes; ++j)
        outputs.arm[i].current_A[j] = arm.current_A[static_cast<int>(j)];
      outputs.arm[i].enable = true;
    } else {
      arm.force_N.setZero();
      arm.torque_N_m.setZero();
      arm.current_A.setZero();
    }
  }
}

}  // namespace thimble::firmware
