// What goes into the renderer and what comes out of it.
#pragma once

#include <cstdint>

#include "kinematics/vector.h"

namespace thimble::control {

// One fingertip, as kinematics gives it this tick.
struct Tip {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_m_s = Vec3::Zero();
};

// What one fingertip feels this tick.
struct Touch {
  Vec3 force_N = Vec3::Zero();       // spring, friction and damping, before any limit of the arm
  Vec3 god_object_m = Vec3::Zero();  // equals the tip in free space
  std::uint8_t contacts = 0;         // active constraints, 0 to 3
};

// Bounds that were hit since bind(): each one is an event to look at, none is an error. Shown in telemetry.
struct RenderCounters {
  std::uint32_t sweep_bound = 0;  // a tree walk was cut short: the god object waited where it was proven free
  std::uint32_t slide_bound = 0;  // a slide over the surface was cut short: it goes on in the next tick
  std::uint32_t contact_bound =
      0;  // more than kMaxBodyContacts points between bodies: the rest did not push in that tick
};

}  // namespace thimble::control
