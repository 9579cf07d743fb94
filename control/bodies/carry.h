// How a moving object changes a god object: one in contact with it is carried along, one in its path is hit
// and pushed.
//
// The objects move one after the other, each while all others stand still. So the path of the god object is
// known piece by piece, and every piece is swept: relative to the moving object in that object's frame, from
// the god object's place in the old pose to its place in the new pose, and relative to all other objects in
// the world frame. The god object is always on the free side of every object.
//
// Between a moving object and another one the god object can have no free path. Then carry() returns false and says where
// it is pinned, and the moving object keeps its old pose (control/bodies/bodies.h).
#pragma once

#include <cstdint>

#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/effort.h"

namespace thimble::control {

// A god object between a moving object and others.
struct Pin {
  Vec3 point_m = Vec3::Zero();
  Vec3 direction = Vec3::Zero();  // in which the god object cannot go further; zero: not known
  std::uint8_t object = kNoBody;  // that holds it there; kNoBody: none, or several
};

// Carries a finger's god object along with object `moved`, whose old pose is in `before` and whose new pose
// is in `world`. False when no path is free: the finger is unchanged.
[[nodiscard]] bool carry(const World& world, std::uint8_t moved, const PlacedObject& before, Finger& finger,
                         Pin& pin, Effort& effort) noexcept;

}  // namespace thimble::control
