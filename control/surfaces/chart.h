// Where on an object's surface a point is, in metres: what a texture is laid out by, so that its spatial frequency is the same
// everywhere, on large faces and on small ones (paper, section 3.8).
//
//   plane, box, mesh    axes made from the face's normal, in the object's frame, through its origin: faces in one plane share
//                       them, and a texture goes on from one to the next. Over an edge it does not.
//   cylinder            the side unrolled: u = radius * angle from +x, v = z; the caps like a plane
//
// A sphere or a capsule cannot be unrolled without stretching; the compiler refuses a texture there.
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

// The gradient with respect to the tip of something that has this gradient in space at the point on the surface: the point goes
// along the surface with the tip, and faster than it on a curved one.
[[nodiscard]] Vec3 carried(const PlacedObject& object, const Place& place, const Vec3& gradient) noexcept;

}  // namespace thimble::control
