// The click of a contact (paper, section 3.2; Kilpatrick 1976): a decaying transient along the normal from
// the tick of contact on,
//
//   F = amplitude (v / 0.1 m/s) exp(-decay t) sin(2 pi frequency t),   v: the speed of the impact
//
// (Okamura, Dennerlein and Howe 2001). It gives no net energy to the hand. The energy budget is the work that
// the hand has done since contact against the transient and the surface's damping. A transient force that
// would give more than half of the budget in one tick is scaled down. A hand that continues to press, or that
// is damped, supplies enough for the whole transient.
#pragma once

#include <cstdint>

#include "control/contact/god_object.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "kinematics/vector.h"

namespace thimble::control {

class ContactClick {
 public:
  // Called in every tick in contact. damping_N: the damping force of this tick. Returns the force of the
  // transient.
  Vec3 tick(const World& world, const Constraints& held, const Tip& tip, const Vec3& damping_N,
            float period_s) noexcept;
  // No contact: the transient ends.
  void release() noexcept { *this = {}; }

 private:
  void start(const World& world, const Constraints& held, const Tip& tip, float period_s) noexcept;
  Vec3 next_transient(const Constraints& held, const Tip& tip, float period_s) noexcept;

  std::uint64_t touching_ = 0;  // one bit an object
  bool ringing_ = false;
  std::uint8_t object_ = 0;  // whose transient it is
  float turn_cos_ = 0.0F;    // rotation of the oscillator in one tick, with its decay
  float turn_sin_ = 0.0F;
  float cos_N_ = 0.0F;  // state of the oscillator
  float sin_N_ = 0.0F;
  float least_N_ = 0.0F;  // amplitude at which it ends
  float energy_budget_J_ = 0.0F;
  Vec3 last_force_N_ =
      Vec3::Zero();  // transient and damping of the last tick, in which the tip was at tip_m_
  Vec3 tip_m_ = Vec3::Zero();
};

}  // namespace thimble::control
