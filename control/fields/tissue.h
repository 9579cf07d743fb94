// The shape of a dimple, for the viewer.
#pragma once

namespace thimble::control {

// The depth of the surface at distance r from the centre of a dimple in an elastic half-space that a round
// flat tip of this radius has pressed: depth (2 / pi) asin(radius / r) beside the tip (Boussinesq; Johnson,
// Contact Mechanics, 1985, section 3.8).
[[nodiscard]] float dimple_depth_m(float depth_m, float radius_m, float r_m) noexcept;

}  // namespace thimble::control
