// The shape of a dimple, for whoever shows it.
#pragma once

namespace thimble::control {

// How deep the surface lies at r from the middle of a dimple that a round flat tip of this radius has pressed, elastic half space: depth
// (2 / pi) asin(radius / r) beside the tip (Boussinesq; Johnson, Contact Mechanics, 1985, section 3.8).
[[nodiscard]] float dimple_depth_m(float depth_m, float radius_m, float r_m) noexcept;

}  // namespace thimble::control
