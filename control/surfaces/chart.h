// Where on an object's surface a point is, in metres: what a texture is laid out by, so that its spatial frequency is the same
// everywhere, on large faces and on small ones (paper, section 3.8).
//
//   plane, box, mesh    axes made from the face's normal, in the object's frame, through its origin: faces in one plane share
//                       them, and a texture goes on from one to the next. Over an edge it does not.
//   cylinder            the side unrolled: u = radius * angle from +x, v = z; the caps like a plane
//
// Other solids have no chart (Texturing::kNone in control/scene/shape_table.h); the compiler refuses a texture there.
#pragma once

#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// A contact in the object's frame: a point on the surface, the unit normal there to the free side, how far the tip is behind it.
struct Place {
  Vec3 at_m;
  Vec3 normal;
  float depth_m;
};

// Coordinates on the surface, and how they change as the tip moves (1; a cylinder's u runs faster below its surface).
struct Chart {
  float u_m = 0.0F;
  float v_m = 0.0F;
  Vec3 du = Vec3::Zero();
  Vec3 dv = Vec3::Zero();
};

[[nodiscard]] Chart chart(const PlacedObject& object, const Place& place) noexcept;

// The gradient with respect to the tip of what has this gradient in space at the point on the surface. The point goes along the
// surface with the tip, and faster than the tip where the surface is curved.
[[nodiscard]] Vec3 gradient_at_tip(const PlacedObject& object, const Place& place,
                                   const Vec3& gradient) noexcept;

// For solids with a curved surface (SolidOps::chart, SolidOps::gradient_at_tip).
// Within 1e-7 of the angle of (x, y), from -pi to pi; 0 at the origin. Our own, as libm's differs from one target to the next.
[[nodiscard]] float angle(float y, float x) noexcept;
// How much faster the point on a convex surface of this radius goes than the tip that is depth_m behind it; at most 4.
[[nodiscard]] float curvature_gain(float radius_m, float depth_m) noexcept;
// `along` with its part round the z axis times `gain`. normal: of the surface, square to the axis.
[[nodiscard]] Vec3 faster_round_axis(const Vec3& normal, float gain, const Vec3& along) noexcept;

}  // namespace thimble::control
