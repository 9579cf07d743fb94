// The contact of a fingertip in a tick.
#pragma once

#include <cstdint>

#include "control/contact/finger.h"
#include "control/contact/nearby.h"
#include "control/contact/world.h"
#include "control/effort.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Of the work of an arm, the part that is the reserve for a shorter way: a quarter.
inline constexpr std::uint32_t kReserve = 4;

[[nodiscard]] bool shares_object(const GodObject& a, const GodObject& b) noexcept;

// Moves a god object in free space towards the tip, and the place that it would have without friction to where the tip draws it, as far as
// there is work. False: nothing pushes. bodies: there are objects that move.
[[nodiscard]] bool find_contact(const World& world, const Nearby& nearby, Finger& finger, const Vec3& tip_m,
                                bool bodies, Effort& effort) noexcept;

}  // namespace thimble::control
