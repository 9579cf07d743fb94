// Collision of two solids in steps, so that a tick can end between any two of them.
//
// It finds all points that are apart by at most the margin. Both objects collide (ShapeRow::collision), and a is no half-space. A point
// lies between the two surfaces; patches of contact with unlike normals have points of their own.
//
// A step is a closed form; some corners of a piece and a plane; one axis between two convex parts or one farthest point of each;
// a node or a triangle of a mesh. It charges what it took to the work (control/work.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "control/bodies/collide.h"
#include "control/bodies/collide_mesh.h"
#include "control/bodies/convex.h"
#include "control/contact/world.h"
#include "control/work.h"

namespace thimble::control {

// A step of the collision of a mesh that moves with a half-space: some corners of a piece. True: that was the last one.
[[nodiscard]] bool meet_corners(const PlacedObject& a, const PlacedObject& plane, float margin_m,
                                std::size_t& piece, std::size_t& corner, Manifold& out) noexcept;

// The same for any object but a half-space. `piece` and `corner` are 0 at the beginning, and 0 again after the last step.
[[nodiscard]] bool meet_plane(const PlacedObject& a, const PlacedObject& plane, std::size_t& piece,
                              std::size_t& corner, Manifold& out) noexcept;

class PairCollision {
 public:
  void begin(const PlacedObject& a, const PlacedObject& b) noexcept;
  // The objects, the margin and `out` are the same ones up to the end. True: `out` has all points.
  [[nodiscard]] bool step(const PlacedObject& a, const PlacedObject& b, float margin_m, Work& work,
                          Manifold& out) noexcept;

 private:
  enum class Kind : std::uint8_t { kClosedForm, kCorners, kParts, kTriangles, kTrianglesOfA };

  [[nodiscard]] bool meet_parts(const PlacedObject& a, const PlacedObject& b, float margin_m,
                                Manifold& out) noexcept;
  [[nodiscard]] bool meet_triangles(const PlacedObject& a, const PlacedObject& b, float margin_m,
                                    Manifold& out) noexcept;

  Kind kind_ = Kind::kClosedForm;
  bool begun_ = false;  // the parts
  std::size_t i_ = 0;   // part of a
  std::size_t j_ = 0;   // part of b, or a corner of a's
  Convex part_a_;
  Convex part_b_;
  ConvexCollision convex_;
  MeshCollision mesh_;
};

}  // namespace thimble::control
