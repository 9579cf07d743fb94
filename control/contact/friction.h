// Friction by the stiction point (paper, section 3.6): position only, two states.
//
// The stiction point is the god object itself. `rest` is where it would be without friction; the tangential
// spring is stretched from there. While the stretch is within the static limit the point stays; beyond it, it
// is moved to the dynamic limit on the line to rest, and in the stick-slip mode that is a new stiction point.
// In the steady mode it is dragged along at the dynamic limit until the tip stops or turns.
#pragma once

#include "control/contact/god_object.h"

namespace thimble::control {

// What all contacts together allow: forces over stiffnesses, as stretches of the tangential spring.
struct FrictionLimits {
  float stiffness_N_m = 0.0F;
  float static_m = 0.0F;
  float dynamic_m = 0.0F;
  bool steady = false;
};

[[nodiscard]] FrictionLimits friction_limits(const Constraints& constraints) noexcept;

class Friction {
 public:
  // The stretch at which the stiction point is to stand: `stretch_m` itself when it sticks.
  float tick(const FrictionLimits& limits, float stretch_m, float period_s) noexcept;
  void reset() noexcept { sliding_ = false; }
  [[nodiscard]] bool sliding() const noexcept { return sliding_; }

 private:
  bool sliding_ = false;  // steady mode only
  float still_s_ = 0.0F;
};

}  // namespace thimble::control
