// Flight through free space. While a fingertip stays within a ball that is known to be free, the god object is at the tip, and a tick has
// nothing to look at.
#pragma once

#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "control/solids/near_triangles.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Flies to the tip where that is known to be free; else false, and nothing is changed.
[[nodiscard]] inline bool fly_in_the_open(Finger& finger, const Vec3& tip_m, Touch& touch) {
  const Clearance& open = finger.open;
  const Vec3 way_m = tip_m - open.at_m;
  if (way_m.squaredNorm() >= open.free_m * open.free_m) return false;
  finger.god.position_m = finger.rest.position_m = tip_m;
  touch = {Vec3::Zero(), tip_m, 0};
  return true;
}

// After a tick that ended without contact: finds such a ball about the tip. triangles: of the finger, or null.
void find_the_open(const World& world, TriangleCache* triangles, Finger& finger, const Vec3& tip_m,
                   Work& work) noexcept;

}  // namespace thimble::control
