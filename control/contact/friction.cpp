#include "control/contact/friction.h"

namespace thimble::control {

FrictionLimits friction_limits(const Constraints& constraints) noexcept {
  FrictionLimits limits;
  float normal_N = 0.0F;
  float static_N = 0.0F;
  float dynamic_N = 0.0F;
  float depth_m = 0.0F;
  for (std::size_t i = 0; i < constraints.count; ++i) {
    const Constraint& c = constraints.list[i];
    const Material& m = c.material;
    const float force_N = m.stiffness_N_m * c.lambda_m;
    normal_N += force_N;
    static_N += m.static_friction * force_N;
    dynamic_N += m.dynamic_friction * force_N;
    depth_m += c.lambda_m;
    limits.steady = limits.steady || m.steady;
  }
  if (!(depth_m > 0.0F) || !(normal_N > 0.0F)) return limits;
  limits.stiffness_N_m = normal_N / depth_m;  // the mean stiffness, by how deep each contact is
  limits.static_m = static_N / limits.stiffness_N_m;
  limits.dynamic_m = dynamic_N / limits.stiffness_N_m;
  return limits;
}

float Friction::tick(const FrictionLimits& limits, float stretch_m, float period_s) noexcept {
  // A tip whose stretch stays below the dynamic limit for this long has stopped. One encoder count in 2 ms is
  // 12 mm/s.
  constexpr float kStopped_s = 2.0e-3F;
  // A stretch below half the dynamic limit means that the tip moves back.
  constexpr float kTurned = 0.5F;
  if (sliding_) {
    constexpr float kRounding = 1.0F + 1.0e-5F;
    if (stretch_m > limits.dynamic_m * kRounding) {
      still_s_ = 0.0F;
      return limits.dynamic_m;
    }
    still_s_ += period_s;
    if (still_s_ < kStopped_s && stretch_m >= kTurned * limits.dynamic_m) return stretch_m;
    sliding_ = false;
  }
  if (stretch_m <= limits.static_m) return stretch_m;
  sliding_ = limits.steady;
  still_s_ = 0.0F;
  return limits.dynamic_m;
}

}  // namespace thimble::control
