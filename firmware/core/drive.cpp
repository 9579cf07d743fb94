#include <algorithm>
#include <cmath>
#include <type_traits>

#include "firmware/core/steps.h"
#include "kinematics/arm.h"
#include "kinematics/motor_current.h"

namespace thimble::firmware {
namespace {

// The torques of the axes for the force and the weight of the arm; 0 where there is no motor. False: one is not finite.
bool find_torques(const Parts& parts, const kinematics::Arm<float>& geometry, ArmState& arm, auto axes,
                  bool probed) noexcept {
  const bool holds_weight = arm.led_N_m == nullptr && parts.params.on(Param::gravity_compensation);
  const Axes weight_N_m = holds_weight ? geometry.gravity_torques(arm.posture) : Axes();
  const float ramp = parts.state.gravity_ramp;
  // No force asks the joints of a redundant arm for what a probe leaves (force.cpp): each gets its part of its own torque.
  const bool by_joint = axes > 3 && probed && arm.redundant && arm.led_N_m == nullptr;
  const Vec3 force_N = by_joint ? arm.unprobed_N : arm.force_N;
  float square = 0;
  for (int j = 0; j < axes; ++j) {
    float torque_N_m = 0;
    if (geometry.is_driven(j)) {
      torque_N_m = arm.led_N_m != nullptr ? (*arm.led_N_m)[j] : arm.posture.jacobian.col(j).dot(force_N);
      if (by_joint) torque_N_m *= arm.probe.part(static_cast<std::size_t>(j));
      if (holds_weight) torque_N_m += ramp * weight_N_m[j];
    }
    arm.torque_N_m[j] = torque_N_m;
    square += torque_N_m * torque_N_m;
  }
  return std::isfinite(square);
}

// Force to torque to currents. False: one is not finite. axes: of the arm, a constant for the compiler where that is worth its code.
bool drive_arm(const Parts& parts, const kinematics::Arm<float>& geometry, ArmState& arm,
               auto axes) noexcept {
  const kinematics::ArmData& data = geometry.data();
  const bool probed = parts.state.mode == Mode::kArmed && arm.probe.probes();
  if (!find_torques(parts, geometry, arm, axes, probed)) return false;
  // A joint gets nothing of what a probe takes from another one.
  if (probed) {
    arm.force_N *= arm.given;
    arm.torque_N_m *= arm.given;
  }
  const float ambient_C = parts.params.get(Param::ambient);
  const float winding_limit_C = parts.params.get(Param::winding_limit);
  Axes limit_A;
  for (int j = 0; j < axes; ++j) {
    if (!geometry.is_driven(j)) continue;
    const auto at = static_cast<std::size_t>(j);
    const kinematics::MotorModel& motor = data.axis[at].motor;
    const float allowed = arm.heat[at].allowed(ambient_C, std::min(winding_limit_C, motor.max_winding_C));
    limit_A[j] = allowed * motor.peak_current_A;
  }
  const int limiting = kinematics::motor_currents(data, axes, arm.torque_N_m, limit_A, arm.current_A);
  float square = 0;
  for (int j = 0; j < axes; ++j) square += arm.current_A[j] * arm.current_A[j];
  if (!std::isfinite(square)) return false;
  if (!probed) arm.given = 1;
  if (limiting == kinematics::kNoAxis) return true;
  // All torques were scaled alike, so the force was too.
  const kinematics::AxisData& axis = data.axis[static_cast<std::size_t>(limiting)];
  const float wanted_A = arm.torque_N_m[limiting] / axis.torque_per_ampere();
  const float scale = arm.current_A[limiting] / wanted_A;
  arm.force_N *= scale;
  arm.torque_N_m *= scale;
  if (!probed) arm.given = scale;
  arm.limiters |= limit_A[limiting] < axis.motor.peak_current_A ? kLimitThermal : kLimitCurrent;
  return true;
}

}  // namespace

void drive(Parts& parts, Outputs& outputs) noexcept {
  State& state = parts.state;
  for (std::size_t i = 0; i < parts.setup.arm_count && motors_on(state.mode); ++i) {
    const kinematics::Arm<float>& geometry = parts.setup.arm[i];
    const bool finite = geometry.axes() == 3 ? drive_arm(parts, geometry, state.arm[i],
                                                         std::integral_constant<int, 3>{})  // most arms
                                             : drive_arm(parts, geometry, state.arm[i], geometry.axes());
    if (finite) continue;
    trip(parts, Fault::torque_not_finite);
    break;
  }
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    if (motors_on(state.mode)) {
      const std::size_t axes = arm.axes;
      for (std::size_t j = 0; j < axes; ++j) outputs.arm[i].current_A[j] = arm.current_A[static_cast<int>(j)];
      outputs.arm[i].enable = true;
    } else {
      arm.force_N.setZero();
      arm.torque_N_m.setZero();
      arm.current_A.setZero();
    }
  }
}

}  // namespace thimble::firmware
