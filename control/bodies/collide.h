// Collision of two solids: contact points, normals and depths, for the contact solver
// (control/bodies/contact_solver.h). control/bodies/pair_collision.h puts it together.
//
// Closed forms: balls and capsules with every primitive; boxes with planes and boxes; cylinders with planes, and with
// cylinders and boxes that have a parallel axis; cones with planes. All other pairs are convex solids of any kind
// (control/bodies/convex.h): a cylinder, a cone, a piece of a moving mesh (scene::Mesh::piece_corners), a triangle of a
// fixed mesh (collide_mesh.cpp). A moving mesh is the union of its pieces. Two meshes without pieces do not meet: the
// compiler gives pieces to every mesh that moves.
//
// Bounds: kMaxPieces pieces a mesh; nodes and triangles of a fixed mesh for each of them (collide_mesh.cpp). That is far more
// than a tick may take, so the contact solver does it in steps (control/bodies/pair_collision.h).
#pragma once

#include <array>
#include <cstddef>

#include "control/contact/world.h"
#include "control/scene/shape_table.h"
#include "control/work.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr std::size_t kMaxManifold = 8;

struct ContactPoint {
  Vec3 point_m = Vec3::Zero();  // between the two surfaces
  Vec3 normal = Vec3::UnitZ();  // pushes a away from b
  float depth_m = 0.0F;         // below 0: apart
};

struct Manifold {
  std::array<ContactPoint, kMaxManifold> points;
  std::size_t count = 0;
  std::uint32_t left_out =
      0;  // how often triangles of a mesh were left out at a bound (control/bodies/collide_mesh.cpp)

  Work* work = nullptr;  // what add() takes; null: not counted

  // When it is full, the two points that are nearest to each other become the deeper one of them.
  void add(const ContactPoint& point) noexcept;
  // Leaves out a point at a place that has one with this normal; the deeper one stays.
  void add_distinct(const ContactPoint& point) noexcept;
};

// Which of the exact collisions a solid takes part in.
enum class CollisionForm : std::uint8_t {
  kHalfSpace,  // stands still
  kBall,
  kCapsule,
  kBox,
  kCylinder,
  kCone,
  kMesh,
};

using LowestPoints = std::array<Vec3, kMaxManifold>;

struct BoxAbout {
  Vec3 centre_m = Vec3::Zero();  // in the object's frame
  Vec3 half_m = Vec3::Zero();
};

// What a solid answers as a body, or to one; its row is in control/scene/shape_table.h.
struct CollisionOps {
  CollisionForm form;
  // The place of the surface nearest to a point: its outward normal there, and how far outside the point is.
  // Null: mesh.
  NearestPlace (*nearest)(const ShapeData& shape, const Vec3& p) = nullptr;
  // Points of the surface that can lie deepest in a half-space; `down` is the direction into it. Null: ball,
  // capsule, half-space, mesh.
  std::size_t (*lowest)(const ShapeData& shape, const Vec3& down, LowestPoints& out) = nullptr;
  BoxAbout (*box_about)(const ShapeData& shape) = nullptr;  // null: ball, capsule, half-space, mesh
};

// Parts of these answers that solids share.
[[nodiscard]] NearestPlace nearest_on_ball(float radius_m, const Vec3& from_centre) noexcept;
[[nodiscard]] NearestPlace nearest_on_box(const Vec3& half_m, const Vec3& p) noexcept;
// Four unit vectors across the z axis, the one that points most along `down` first.
[[nodiscard]] std::array<Vec3, 4> rim_directions(const Vec3& down) noexcept;

// Parts of PairCollision. False: there is no closed form for the two, of which none is a mesh.
[[nodiscard]] bool collide_in_closed_form(const PlacedObject& a, const PlacedObject& b, float margin_m,
                                          Manifold& out) noexcept;
void collide_point_with_plane(const PlacedObject& plane, const Vec3& point, float margin,
                              Manifold& out) noexcept;
void flip_normals(Manifold& manifold) noexcept;

// Two oriented boxes: separating axis test, then the incident face is clipped (Gottschalk 1996; Catto 2006).
struct OrientedBox {
  Vec3 centre_m = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
  Vec3 half_m = Vec3::Zero();
};
void collide_boxes(const OrientedBox& a, const OrientedBox& b, float margin_m, Manifold& out) noexcept;

}  // namespace thimble::control
