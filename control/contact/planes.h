// The planes that a god object lies on.
#pragma once

#include <array>
#include <cstddef>

#include "control/contact/god_object.h"
#include "control/contact/half_spaces.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The planes at the god object, each with its contact. A plane's offset is how far the god object is behind the surface,
// from rounding.
constexpr std::size_t kMaxPlanes = 2 * kMaxContacts;

struct Planes {
  std::array<HalfSpace, kMaxPlanes> plane;
  std::array<std::size_t, kMaxPlanes> contact;
  std::size_t count = 0;
};

[[nodiscard]] Planes planes_at(const World& world, const GodObject& god) noexcept;

// The displacement nearest to r that the planes allow; none where there is no answer.
[[nodiscard]] NearestInside project(const Planes& planes, const Vec3& r) noexcept;

}  // namespace thimble::control
