// Charts: coordinates on the surface of an object, in metres. Textures use them, so that their spatial
// frequency is the same on large and small faces (paper, section 3.8).
//
//   plane, box                 axes from the normal of the face, in the object's frame, through its origin
//   cylinder                   the side unrolled: u = radius * angle from +x, v = z; the caps like a plane
//   sphere, capsule, cone,     no chart: blended along the object's axes (control/scene/blend.h). Flat parts of a mesh
//   mesh                       that end at corners of 90 degrees or more, and a cone's base, like a plane
//   mesh with coordinates      those of its file, in metres
//
// A tip is not pressed from one face to the next over a convex corner of 90 degrees or more, so there a texture may restart.
#pragma once

#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// A contact in the object's frame: a point on the surface, the unit normal there to the free side, how far
// the tip is behind it.
struct SurfacePoint {
  Vec3 at_m;
  Vec3 normal;
  float depth_m;
  Feature feature;
};

// Coordinates on the surface, and their gradients with respect to the tip. Below a curved surface these are
// larger than 1.
struct Chart {
  float u_m = 0.0F;
  float v_m = 0.0F;
  Vec3 du = Vec3::Zero();
  Vec3 dv = Vec3::Zero();
  bool in_space = false;  // the gradients may point out of the surface
  float strength = 1.0F;  // of the texture at this place, and its gradient
  Vec3 strength_slope = Vec3::Zero();
};

[[nodiscard]] Chart plane_chart(const Vec3& normal, const Vec3& at_m) noexcept;
[[nodiscard]] Chart chart(const PlacedObject& object, const SurfacePoint& place) noexcept;

// The gradient with respect to the tip of what has this gradient in space at the point on the surface. The
// point goes along the surface with the tip, and faster than the tip where the surface is curved.
[[nodiscard]] Vec3 gradient_at_tip(const PlacedObject& object, const SurfacePoint& place,
                                   const Vec3& gradient) noexcept;

// For solids with a curved surface (SolidOps::chart, SolidOps::gradient_at_tip). Within 1e-7 of the angle of
// (x, y), from -pi to pi; 0 at the origin. Our own, as libm's differs from one target to the next.
[[nodiscard]] float angle(float y, float x) noexcept;
// How much faster the point on a convex surface of this radius goes than the tip that is depth_m behind it;
// at most 4.
[[nodiscard]] float curvature_gain(float radius_m, float depth_m) noexcept;
// `along` with its part round the z axis times `gain`. normal: of the surface, square to the axis.
[[nodiscard]] Vec3 faster_round_axis(const Vec3& normal, float gain, const Vec3& along) noexcept;

}  // namespace thimble::control
