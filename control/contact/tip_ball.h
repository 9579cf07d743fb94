// A tip with a radius as a ball (contact/ball.h): its contacts, and the short ways over a mesh that need no planes.
#pragma once

#include <cstddef>

#include "control/contact/god_object.h"
#include "control/contact/separations.h"

namespace thimble::control {

// With one plane more, if it is not among those that hold the point.
[[nodiscard]] NearestInside with_plane(const NearestInside& there, std::size_t plane) noexcept;

// Stops where it has moved to, if it touches all planes that hold it with their normals: then it would not move on. False,
// and nothing is changed, where it does not.
[[nodiscard]] bool stop_on(const World& world, GodObject& god, const NearestInside& there,
                           const Separations& near) noexcept;

// Takes over the planes that hold its centre back.
void set_tip_contacts(GodObject& god, Separations& near, const Vec3& target, bool hold,
                      float radius_m) noexcept;

// Whether it flies far from the only solid nearby, which is a mesh.
[[nodiscard]] bool is_clear(const World& world, const Nearby& nearby, Work& work, const Vec3& centre,
                            const Vec3& target) noexcept;

// The short way of a tip with a radius that touches one part of a mesh, with nothing else nearby. False, and nothing is
// changed, where that is not certain.
[[nodiscard]] bool roll(const World& world, const Nearby& nearby, Work& work, GodObject& god,
                        const Vec3& target, bool hold) noexcept;

}  // namespace thimble::control
