// The click of a contact (paper, section 3.2; Kilpatrick 1976): a decaying transient along the normal from the tick of contact on,
//
//   F = amplitude (v / 0.1 m/s) exp(-decay t) sin(2 pi frequency t),   v: the speed of the impact
//
// (Okamura, Dennerlein and Howe 2001). It gives the hand no energy: a purse holds what the hand has spent since contact on the
// transient itself and on the surface's damping, which is lost otherwise, and a swing that would give more than half of it in a tick is
// scaled down. A hand that goes on into the surface, or a damped one, pays for all of it.
#pragma once

#include <cstdint>

#include "control/contact/god_object.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "kinematics/vector.h"

namespace thimble::control {

class ContactClick {
 public:
  // Every tick in contact. damping_N: the damping's force in this tick. Returns the transient's.
  Vec3 tick(const World& world, const Constraints& held, const Tip& tip, const Vec3& damping_N,
            float period_s) noexcept;
  // No contact: what rings is cut off.
  void release() noexcept { *this = {}; }

 private:
  void start(const World& world, const Constraints& held, const Tip& tip, float period_s) noexcept;
  Vec3 swing(const Constraints& held, const Tip& tip, float period_s) noexcept;

  std::uint64_t touching_ = 0;  // one bit an object
  bool ringing_ = false;
  std::uint8_t object_ = 0;  // that rings
  float turn_cos_ = 0.0F;    // one tick of the oscillator, its decay included
  float turn_sin_ = 0.0F;
  float cos_N_ = 0.0F;  // where it is
  float sin_N_ = 0.0F;
  float least_N_ = 0.0F;  // when it has ended
  float purse_J_ = 0.0F;
  Vec3 paid_by_N_ =
      Vec3::Zero();  // transient and damping of the last tick, while the tip moved on from tip_m_
  Vec3 tip_m_ = Vec3::Zero();
};

}  // namespace thimble::control
