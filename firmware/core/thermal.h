// Two-node thermal model of one motor, winding and housing, and the current limit that follows from it. add()
// is called every tick; the nodes are stepped every kStep_s, because the change of the housing in one tick
// would be lost in the rounding of a float.
//
//   C_w dT_w/dt = I^2 R(T_w) - (T_w - T_h)/R_wh      C_h dT_h/dt = (T_w - T_h)/R_wh - (T_h - T_a)/R_ha
//   R(T) = R_25 (1 + 0.00393 (T - 25))               C = time constant / thermal resistance
//
// Units: A, degC, s. Cannot fail with finite currents. At most one step per call.
#pragma once

#include "kinematics/arm_model.h"

namespace thimble::firmware {

class MotorHeat {
 public:
  static constexpr float kStep_s = 0.01F;
  static constexpr float kDerateFrom_C = 20.0F;  // below the limit: full current
  static constexpr float kDerateTo_C =
      5.0F;  // below the limit: none. The model's error must not burn the motor

  void add(const kinematics::MotorModel& motor, float current_A, float ambient_C, float period_s) noexcept {
    charge_A2_s_ += current_A * current_A * period_s;
    time_s_ += period_s;
    if (time_s_ < kStep_s) return;
    const float resistance = motor.resistance_ohm * (1.0F + 0.00393F * (winding_C(ambient_C) - 25.0F));
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

}  // namespace thimble::firmware
