// Friction by the stiction point (paper, section 3.6): position only, two states. Both paths of the renderer
// use it.
//
// The stiction point is the god object itself. `rest` is where the god object would be without friction; the
// tangential spring is stretched from there. While the stretch is within the static limit, the stiction point
// stays. Beyond it, the point slips to the dynamic limit on the line to rest. In the stick-slip mode that
// place is a new stiction point. In the steady mode the point is dragged along at the dynamic limit until the
// tip stops or turns.
#pragma once

#include "control/contact/god_object.h"
#include "kinematics/vector.h"

namespace thimble::control {

// What all contacts together allow: forces over stiffnesses, as stretches of the tangential spring.
struct FrictionLimits {
  float stiffness_N_m = 0.0F;
  float static_m = 0.0F;
  float dynamic_m = 0.0F;
  bool steady = false;
};

// Of one surface that the tip is depth_m behind; what the function below gives for one constraint, but for
// rounding.
[[nodiscard]] inline FrictionLimits friction_limits(const Material& material, float depth_m) noexcept {
  return {material.stiffness_N_m, material.static_friction * depth_m, material.dynamic_friction * depth_m,
          material.steady};
}

[[nodiscard]] FrictionLimits friction_limits(const Constraints& constraints) noexcept;

// What friction makes of the stretch in one tick.
struct Slip {
  bool slips = false;
  Vec3 offset_m;  // when it slips: from rest to where the stiction point is to go
};

class Friction {
 public:
  // The stretch at which the stiction point is to stand: `stretch_m` itself when it sticks.
  float tick(const FrictionLimits& limits, float stretch_m, float period_s) noexcept;

  // The same for the stretch as a vector, from rest to the stiction point.
  [[gnu::always_inline]] inline Slip tick(const FrictionLimits& limits, const Vec3& pull_m,
                                          float period_s) noexcept {
    const float stretch_m = pull_m.norm();
    const float allowed_m = tick(limits, stretch_m, period_s);
    if (!(allowed_m < stretch_m)) return {};
    return {true, (allowed_m / stretch_m) * pull_m};
  }

  void reset() noexcept { sliding_ = false; }
  [[nodiscard]] bool sliding() const noexcept { return sliding_; }

 private:
  bool sliding_ = false;  // steady mode only
  float still_s_ = 0.0F;
};

// Whether one way is longer than the other by more than rounding: a fraction of its length, and the step of a
// float at 0.25 m, because the end points of the ways are rounded wherever they are.
[[nodiscard]] inline bool is_longer(const Vec3& way_m, const Vec3& than_m) noexcept {
  constexpr float kPart = 1.0F + 1.0e-5F;
  constexpr float kStep_m = 3.0e-8F;
  return way_m.norm() > kPart * than_m.norm() + kStep_m;
}

// Whether a slip does not tighten the spring. Over a ridge it could; then the stiction point goes to rest
// instead. nearest_to_m: what rest is nearest to.
[[nodiscard]] inline bool loosens(const Vec3& slipped_m, const Vec3& stuck_m, const Vec3& rest_m,
                                  const Vec3& nearest_to_m) noexcept {
  return !is_longer(slipped_m - rest_m, stuck_m - rest_m) &&
         !is_longer(slipped_m - nearest_to_m, stuck_m - nearest_to_m);
}

// Friction can only increase the distance to the tip. A rest position farther from the tip than the stiction
// point does not belong to this contact.
[[nodiscard]] [[gnu::always_inline]] inline bool is_farther(const Vec3& rest, const Vec3& stuck,
                                                            const Vec3& tip) noexcept {
  constexpr float kRounding2 = 1.0F + 2.0e-5F;
  return (rest - tip).squaredNorm() > kRounding2 * (stuck - tip).squaredNorm();
}

}  // namespace thimble::control
