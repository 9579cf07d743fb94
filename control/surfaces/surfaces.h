// The effects of the surfaces of the objects in contact: brake, stiffness map, texture (paper, sections 3.2,
// 3.8 and 5.1). Called by the renderer when an object in contact has effects of a surface, after the rest
// position is found and before friction, so that friction, damping and the energy account use the changed
// constraints.
//
// With d the depth below the shape's surface, n its normal, h(u, v) <= 0 the texture's height over it and
// K(u, v) the map:
//
//   height    F = K (d + h) (n - grad h), the gradient of (K / 2)(d + h)^2: no force until the tip is below the relief
//   normal    F = K d n', n' along n - grad h
//   lateral   F = K d (n - grad h): Minsky's force along the surface, in proportion to the normal force
//   map       F = K d n; conservative: also -(d^2 / 2) grad K, so that F is the gradient of (K / 2) d^2
#pragma once

#include "control/contact/god_object.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

struct SurfaceTouch {
  Vec3 along_N = Vec3::Zero();  // forces beside the springs'
  Vec3 sunk_m =
      Vec3::Zero();       // from the textured surface up to the shape's: what of the depth is not pressed
  bool potential = true;  // false: a loop over this surface could give energy
};

// Changes the material, normal and lambda of each constraint, and removes the constraints that the tip does
// not press. rest: the god object that `held` belongs to.
[[nodiscard]] SurfaceTouch apply_surfaces(const World& world, const GodObject& rest, const Vec3& tip_m,
                                          Constraints& held) noexcept;

}  // namespace thimble::control
