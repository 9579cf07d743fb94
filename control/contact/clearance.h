// How far all objects but one are from a fingertip: while it stays within that, a tick need not look at them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

struct Clearance {
  std::uint8_t object = kNoBody;  // the one that does not count
  Vec3 at_m = Vec3::Zero();
  float free_m = 0.0F;  // a ball of this radius about at_m meets no other object

  // Whether a ball about the tip meets no other object.
  [[nodiscard]] bool holds(std::size_t but, const Vec3& tip_m, float radius_m) const {
    return object == but && (tip_m - at_m).norm() + radius_m <= free_m;
  }
};

// As boxes and half-spaces tell, in this tick: a body may come nearer in the next one.
[[nodiscard]] inline Clearance clearance(const World& world, std::size_t but, const Vec3& tip_m) {
  float free_m = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < world.count; ++i) {
    const PlacedObject& o = world.objects[i];
    if (i == but) continue;
    const float away_m = o.half_space ? o.normal.dot(tip_m) - o.offset_m
                                      : (tip_m - tip_m.cwiseMax(o.lo_m).cwiseMin(o.hi_m)).norm();
    free_m = std::min(free_m, away_m);
  }
  return {static_cast<std::uint8_t>(but), tip_m, free_m};
}

}  // namespace thimble::control
