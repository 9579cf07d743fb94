// The scale of a contact's springs with which no closed path of the tip gains energy (EnergyAccount, ContactPotential).
#pragma once

#include <algorithm>
#include <cstdint>

#include "control/contact/finger.h"
#include "control/contact/god_object.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The object in whose frame the energy account counts the work. Work on a moving object is counted relative to
// that object. Null between objects that move differently: there is no such frame. rest: the god object, in contact; above a
// relief nothing holds it back, and the contact goes on.
[[nodiscard]] const PlacedObject* account_frame(const World& world, const GodObject& rest,
                                                const Constraints& held) noexcept;

// What the spring of a contact does: the force without damping, and the energy that it returns when it is let go.
struct Spring {
  Vec3 pull_m;  // from the tip to what pulls it
  Vec3 force_N;
  float stored_J;
  float falls = 0.0F;  // EnergyAccount::tick()
};

// Of one spring: force times stretch, halved. A shaded normal can turn it against the pull.
[[nodiscard]] inline float stored_J(const Vec3& force_N, const Vec3& pull_m) {
  return 0.5F * std::max(force_N.dot(pull_m), 0.0F);
}

// The scale of the spring force, 0 to 1, with which no closed path of the tip gains energy. All is in the frame of
// `body`. gradient: the force is that of the potential that holds the tip since the contact began.
[[nodiscard]] [[gnu::always_inline]] inline float passive_scale(Finger& finger, std::uint8_t body,
                                                                const Vec3& tip_m, const Spring& spring,
                                                                bool gradient) {
  if (!gradient || !finger.account.exact(body))
    return finger.account.tick(body, tip_m, spring.pull_m.norm(), spring.stored_J, spring.force_N,
                               finger.shaded.took_part(), spring.falls);
  finger.account.follow(body, tip_m, spring.stored_J, spring.force_N);
  return 1.0F;
}

// The same for all springs of a contact, in the world frame. gradient: each contact's force is the gradient of a potential.
[[nodiscard]] float passive_scale(const World& world, Finger& finger, const Constraints& held,
                                  const Vec3& tip_m, const Spring& spring, bool gradient) noexcept;

}  // namespace thimble::control
