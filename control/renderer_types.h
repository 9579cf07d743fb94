// The inputs and outputs of the renderer.
#pragma once

#include <cstdint>

#include "kinematics/vector.h"

namespace thimble::control {

// One fingertip in this tick, from the kinematics.
struct Tip {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_m_s = Vec3::Zero();
};

// The result for one fingertip in this tick.
struct Touch {
  Vec3 force_N = Vec3::Zero();       // spring, friction and damping, before any limit of the arm
  Vec3 god_object_m = Vec3::Zero();  // equals the tip in free space
  std::uint8_t contacts = 0;         // active constraints, 0 to 3
};

// How often each bound was reached since bind(). None is an error; telemetry shows them.
struct RenderCounters {
  std::uint32_t sweep_bound =
      0;  // a tree walk was cut short: the god object stayed at a place that was proven free
  std::uint32_t slide_bound = 0;  // a slide over the surface was cut short: it continues in the next tick
  std::uint32_t contact_bound =
      0;  // contact points between bodies beyond kMaxBodyContacts: their patch had fewer points in that tick; and
          // triangles of a mesh left out at a bound (control/bodies/collide_mesh.cpp)
  std::uint32_t put_off = 0;    // ticks whose work was spent: the rest was put off (control/work.h)
  std::uint32_t most_work = 0;  // of a tick, in units
  std::uint8_t put_off_object =
      kNoObject;  // index in the scene of the object that the work of the last of these ticks was spent on
  static constexpr std::uint8_t kNoObject = 255;
};

}  // namespace thimble::control
