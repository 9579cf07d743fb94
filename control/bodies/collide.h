// Where two solids meet: points, normal and depth, for the contacts between bodies (control/bodies/contact_solver.h).
//
// Exact: balls and capsules with everything; boxes with planes and boxes; cylinders with planes, and with cylinders and boxes whose
// axes are parallel to theirs (pucks). A cylinder that lies askew to a cylinder or a box meets it as the box about it would.
// Meshes meet nothing but fingertips. No loop is longer than kMaxManifold times the sides of a box.
#pragma once

#include <array>
#include <cstddef>

#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr std::size_t kMaxManifold = 8;

struct Meeting {
  Vec3 point_m = Vec3::Zero();  // between the two surfaces
  Vec3 normal = Vec3::UnitZ();  // pushes a away from b
  float depth_m = 0.0F;         // below 0: apart
};

struct Manifold {
  std::array<Meeting, kMaxManifold> points;
  std::size_t count = 0;

  // Keeps the deepest.
  void add(const Meeting& meeting) noexcept;
};

// Whether objects of this shape meet others at all.
[[nodiscard]] constexpr bool collides(scene::Shape shape) { return shape < scene::Shape::Mesh; }

// All points that are apart by at most margin_m. kind_a and kind_b are the shapes of a and b; a is no plane.
void collide(scene::Shape kind_a, const PlacedObject& a, scene::Shape kind_b, const PlacedObject& b,
             float margin_m, Manifold& out) noexcept;

// Boxes by their half sizes and poses, by the separating axes and by clipping the face that meets (Gottschalk 1996; Catto 2006).
struct OrientedBox {
  Vec3 centre_m = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
  Vec3 half_m = Vec3::Zero();
};
void collide_boxes(const OrientedBox& a, const OrientedBox& b, float margin_m, Manifold& out) noexcept;

}  // namespace thimble::control
