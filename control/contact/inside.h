// The solids that a tip began inside of: its first tick after Renderer::bind() or reset() found it there (arming, a new
// scene, a tip that was put somewhere else). The finger does not feel them until the tip has left them.
#pragma once

#include <cstdint>

#include "control/contact/world.h"
#include "control/effort.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Bit i: object i of the world.
using SolidSet = std::uint64_t;
static_assert(kMaxObjects <= 64);

[[nodiscard]] constexpr SolidSet only(std::size_t object) noexcept { return SolidSet{1} << object; }

// Those of `among` that hold the point, or that a tip with a radius reaches into when its centre is there. A sheet holds no
// point. A point that the bounded test of a mesh gives no answer for counts as inside, because what is not felt exerts no
// force; sweep_bound counts it.
[[nodiscard]] SolidSet solids_around(const World& world, SolidSet among, const Vec3& centre_m,
                                     Effort& effort) noexcept;

}  // namespace thimble::control
