// Two-node thermal model of one motor, winding and housing, and the current limit that follows from it. add()
// is called every tick; the nodes are stepped every kStep_s, because the change of the housing in one tick
// would be lost in the rounding of a float.
//
//   C_w dT_w/dt = I^2 R(T_w) - (T_w - T_h)/R_wh      C_h dT_h/dt = (T_w - T_h)/R_wh - (T_h - T_a)/R_ha
//   R(T) = R_25 (1 + 0.00393 (T - 25))               C = time constant / thermal resistance
//
// Units: A, degC, s. Cannot fail with finite currents. At most one step per call, however long: after lost ticks it is one of backward
// Euler, because a long explicit step goes below the ambient temperature and further.
//
// After a restart the model resumes from the journal. cooled() is for a time in which the motors were off, heated() for one that nobody
// knows: they give a temperature that is not below the true one.
#pragma once

#include <algorithm>

#include "firmware/core/motors_heat.h"
#include "kinematics/arm_data.h"

namespace thimble::firmware {

// One step of backward Euler in which the winding takes this energy. It is stable however long it is, and cools slower than the exact
// solution.
[[nodiscard]] inline Heat long_step(const kinematics::MotorModel& motor, const Heat& heat, float energy_J,
                                    float seconds) noexcept {
  const float a = seconds / motor.winding_time_constant_s;
  const float c = seconds / motor.housing_time_constant_s;
  const float b = c * motor.housing_to_ambient_K_W / motor.winding_to_housing_K_W;
  const float winding_K =
      heat.winding_K + energy_J * motor.winding_to_housing_K_W / motor.winding_time_constant_s;
  Heat after;
  after.housing_K = (heat.housing_K + b / (1 + a) * winding_K) / (1 + c + b / (1 + a));
  after.winding_K = (winding_K + a * after.housing_K) / (1 + a);
  return after;
}

class MotorHeat {
 public:
  static constexpr float kStep_s = 0.01F;
  static constexpr float kLong_s = 0.1F;         // a hundredth of a winding's time constant
  static constexpr float kDerateFrom_C = 20.0F;  // below the limit: full current
  static constexpr float kDerateTo_C =
      5.0F;  // below the limit: none. The model's error must not burn the motor

  void add(const kinematics::MotorModel& motor, float current_A, float ambient_C, float period_s) noexcept {
    charge_A2_s_ += current_A * current_A * period_s;
    time_s_ += period_s;
    if (time_s_ < kStep_s) return;
    const float resistance = motor.resistance_ohm * (1.0F + 0.00393F * (winding_C(ambient_C) - 25.0F));
    if (time_s_ > kLong_s) {
      const Heat after = long_step(motor, heat(), charge_A2_s_ * resistance, time_s_);
      resume({.winding_K = after.winding_K, .housing_K = after.housing_K});
      return;
    }
    const float to_housing_J = (winding_K_ - housing_K_) / motor.winding_to_housing_K_W * time_s_;
    const float to_ambient_J = housing_K_ / motor.housing_to_ambient_K_W * time_s_;
    winding_K_ += (charge_A2_s_ * resistance - to_housing_J) * motor.winding_to_housing_K_W /
                  motor.winding_time_constant_s;
    housing_K_ +=
        (to_housing_J - to_ambient_J) * motor.housing_to_ambient_K_W / motor.housing_time_constant_s;
    charge_A2_s_ = 0;
    time_s_ = 0;
  }

  [[nodiscard]] float winding_C(float ambient_C) const noexcept { return ambient_C + winding_K_; }

  // The part of the peak current that the winding may take: 1 when cool, 0 near the limit.
  [[nodiscard]] float allowed(float ambient_C, float limit_C) const noexcept {
    const float part = (limit_C - kDerateTo_C - winding_C(ambient_C)) / (kDerateFrom_C - kDerateTo_C);
    return part < 0.0F ? 0.0F : part > 1.0F ? 1.0F : part;
  }

  [[nodiscard]] Heat heat() const noexcept { return {winding_K_, housing_K_}; }
  void take_off(const Heat& less) noexcept {
    winding_K_ = std::max(winding_K_ - less.winding_K, 0.0F);
    housing_K_ = std::max(housing_K_ - less.housing_K, 0.0F);
  }

  // The complete state, for the start record of a recording.
  struct State {
    float winding_K = 0;
    float housing_K = 0;
    float charge_A2_s = 0;
    float time_s = 0;
  };
  [[nodiscard]] State state() const noexcept { return {winding_K_, housing_K_, charge_A2_s_, time_s_}; }
  void resume(const State& state) noexcept {
    winding_K_ = state.winding_K;
    housing_K_ = state.housing_K;
    charge_A2_s_ = state.charge_A2_s;
    time_s_ = state.time_s;
  }

 private:
  float winding_K_ = 0;  // above ambient
  float housing_K_ = 0;
  float charge_A2_s_ = 0;  // since the last step
  float time_s_ = 0;
};

// The heat after a time without current. Backward Euler: it cools slower than the exact solution, with any step.
[[nodiscard]] inline Heat cooled(const kinematics::MotorModel& motor, Heat heat, float seconds) noexcept {
  constexpr int kSteps = 1000;
  constexpr float kMost_s = 1e6F;  // cold by then
  const float step_s = std::min(seconds, kMost_s) / static_cast<float>(kSteps);
  for (int i = 0; i < kSteps && seconds > 0; ++i) heat = long_step(motor, heat, 0, step_s);
  return heat;
}

// The most heat after a time in which the current is not known: all that the limits allow.
[[nodiscard]] inline Heat heated(const kinematics::MotorModel& motor, const Heat& heat, float ambient_C,
                                 float limit_C, float seconds) noexcept {
  MotorHeat model;
  model.resume({.winding_K = heat.winding_K, .housing_K = heat.housing_K});
  const auto steps = static_cast<int>(seconds / MotorHeat::kStep_s);
  for (int i = 0; i < steps; ++i)
    model.add(motor, model.allowed(ambient_C, limit_C) * motor.peak_current_A, ambient_C, MotorHeat::kStep_s);
  return model.heat();
}

}  // namespace thimble::firmware
