// The forces of a contact beside its springs: damping, and what moving objects get of the finger's force. World frame.
// Called by the renderer, once a tick for each fingertip in contact. god_m: the god object.
#pragma once

#include <cstdint>

#include "control/bodies/bodies.h"
#include "control/contact/finger.h"
#include "control/contact/god_object.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The velocity of the tip relative to the object's material at the god object.
[[nodiscard]] Vec3 relative_velocity(const PlacedObject& object, const Bodies& bodies, const Vec3& at,
                                     const Vec3& velocity) noexcept;

// Along the normals of all contacts.
[[nodiscard]] Vec3 damping_force(const World& world, const Bodies& bodies, const Constraints& held,
                                 const Vec3& god_m, const Vec3& velocity) noexcept;

// Damping along the surfaces of moving objects while friction holds the tip: without it a held object swings on the
// springs of the fingertips. It acts against the motion of the tip relative to the object, so it is passive; with the
// friction spring it stays within the limit of friction, and in one tick it stops at most half of that motion. It grows
// up to kHeldSpeed_m_s: a tip that sticks and slips is faster, and damping would level the slips that the hand feels.
[[nodiscard]] Vec3 damping_along(const World& world, const Bodies& bodies, const Finger& finger,
                                 const Constraints& held, const Vec3& velocity, const Vec3& friction_N,
                                 const FrictionLimits& limits, float period_s) noexcept;

// Applies to every moving object in contact the opposite of its force on the finger: spring and damping along
// its own normal, and its share of the rest (friction, effects of surfaces), in proportion to its static
// friction limit.
void push_back(const World& world, Bodies& bodies, std::uint8_t finger, const Constraints& held,
               const Vec3& god_m, const Vec3& velocity, const Vec3& force) noexcept;

}  // namespace thimble::control
