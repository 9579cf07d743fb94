#include <algorithm>
#include <cmath>

#include "firmware/core/steps.h"
#include "kinematics/dynamics.h"
#include "kinematics/motor_current.h"

namespace thimble::firmware {
namespace {

// Force to torque to currents. False: one is not finite.
bool drive_arm(const Parts& parts, const kinematics::ArmModel& model, ArmState& arm) noexcept {
  arm.torque_N_m = arm.posture.jacobian.transpose() * arm.force_N;
  if (parts.params.on(Param::gravity_compensation))
    arm.torque_N_m += parts.state.gravity_ramp * kinematics::gravity_torques(model.inertia, arm.posture);
  if (!finite(arm.torque_N_m)) return false;
  // A joint gets nothing of what a probe takes from another one.
  const bool probed = parts.state.mode == Mode::kArmed && arm.probe.probes();
  if (probed) {
    arm.force_N *= arm.given;
    arm.torque_N_m *= arm.given;
  }
  const float ambient_C = parts.params.get(Param::ambient);
  const float limit_C = std::min(parts.params.get(Param::winding_limit), model.motor.max_winding_C);
  Vec3 limit_A;
  bool derated = false;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const float allowed = arm.heat[j].allowed(ambient_C, limit_C);
    limit_A[static_cast<int>(j)] = allowed * model.motor.peak_current_A;
    derated = derated || allowed < 1.0F;
  }
  const auto currents = kinematics::motor_currents(model, arm.torque_N_m, limit_A);
  if (!finite(currents.value)) return false;
  arm.current_A = currents.value;
  if (!probed) arm.given = 1;
  if (currents.which == kinematics::CurrentLimit::kNone) return true;
  // All torques were scaled alike, so the force was too.
  const int limiting = static_cast<int>(currents.which) - 1;
  const float wanted_A = arm.torque_N_m[limiting] / model.torque_per_ampere(limiting);
  const float scale = currents.value[limiting] / wanted_A;
  arm.force_N *= scale;
  arm.torque_N_m *= scale;
  if (!probed) arm.given = scale;
  arm.limiters |= derated && limit_A[limiting] < model.motor.peak_current_A ? kLimitThermal : kLimitCurrent;
  return true;
}

}  // namespace

void drive(Parts& parts, Outputs& outputs) noexcept {
  State& state = parts.state;
  for (std::size_t i = 0; i < parts.setup.arm_count && motors_on(state.mode); ++i) {
    if (drive_arm(parts, parts.setup.arm[i].model(), state.arm[i])) continue;
    trip(parts, Fault::torque_not_finite);
    break;
  }
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    if (motors_on(state.mode)) {
      for (std::size_t j = 0; j < kJoints; ++j)
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
