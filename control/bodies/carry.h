// What a moving object does to a god object: one that touches it goes along, one in its way is met and pushed.
//
// Each object moves alone while all the others stand still, so the god object's way is known piece by piece and every piece is
// swept: relative to the moving object in that object's frame, from where the old pose had the god object to where the new pose
// has it, and relative to all the others in the world. It is always on the free side of every one of them.
//
// Squeezed between a moving object and another one a point has no way out. It is a pebble then, not a ghost: carry() says so, and
// the object stays where it was (control/bodies/bodies.h).
#pragma once

#include <cstdint>

#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"

namespace thimble::control {

// Takes a finger's god object along with object `moved`, which stood where `before` says and now stands where the world says.
// False when there is no way: the finger is unchanged.
[[nodiscard]] bool carry(const World& world, std::uint8_t moved, const PlacedObject& before, Finger& finger,
                         RenderCounters& counters) noexcept;

}  // namespace thimble::control
