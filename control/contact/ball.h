// The god object as a small ball. Where several solids are near, a point could enter the gap between two that
// touch, however narrow; a ball rolls over it, and over a step by rounding.
//
// The ball moves to the place nearest to its target that planes between it and the solids allow (contact/
// separations.h), takes new planes there, and goes on. So every piece of its path is straight and free. The god object,
// from which the force comes, is the point under it on the surfaces themselves.
//
// A tip with a radius is such a ball wherever it is, and the god object is its centre.
#pragma once

#include "control/contact/god_object.h"
#include "control/effort.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Both make the god object a ball if it is a point yet, and are otherwise as fly() and move() of a point. False where its path past a mesh
// of several parts is not proven free, or leads away from the target; the god object is as before then.
bool fly_ball(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
              Effort& effort) noexcept;
bool move_ball(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
               Effort& effort) noexcept;

// Makes the god object a point again, on the surfaces that it touches.
void leave_ball(const World& world, GodObject& god) noexcept;

}  // namespace thimble::control
