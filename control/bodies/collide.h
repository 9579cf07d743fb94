// Collision of two solids: contact points, normals and depths, for the contact solver
// (control/bodies/contact_solver.h).
//
// Exact: balls and capsules with every solid; boxes with planes and boxes; cylinders with planes, and with
// cylinders and boxes that have a parallel axis; cones with planes. In all other pairs a cylinder or cone
// collides as its bounding box would. Meshes collide with fingertips only. No loop is longer than
// kMaxManifold times the number of faces of a box.
#pragma once

#include <array>
#include <cstddef>

#include "control/contact/world.h"
#include "control/scene/shape_table.h"
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

  // When it is full, the least deep point is dropped.
  void add(const ContactPoint& point) noexcept;
};

// Which of the exact collisions a solid takes part in.
enum class CollisionForm : std::uint8_t {
  kHalfSpace,  // stands still
  kBall,
  kCapsule,
  kBox,
  kCylinder,
  kOther,  // exact with balls, capsules and half-spaces; with the rest as the box about it
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
  NearestPlace (*nearest)(const ShapeData& shape, const Vec3& p);
  // Points of the surface that can lie deepest in a half-space; `down` is the direction into it. Null: ball,
  // capsule, half-space.
  std::size_t (*lowest)(const ShapeData& shape, const Vec3& down, LowestPoints& out) = nullptr;
  BoxAbout (*box_about)(const ShapeData& shape) = nullptr;  // null: ball, capsule, half-space
};

// Parts of these answers that solids share.
[[nodiscard]] NearestPlace nearest_on_ball(float radius_m, const Vec3& from_centre) noexcept;
[[nodiscard]] NearestPlace nearest_on_box(const Vec3& half_m, const Vec3& p) noexcept;
// Four unit vectors across the z axis, the one that points most along `down` first.
[[nodiscard]] std::array<Vec3, 4> rim_directions(const Vec3& down) noexcept;

// All points that are apart by at most margin_m. Both objects collide (ShapeRow::collision), and a is no
// half-space.
void collide(const PlacedObject& a, const PlacedObject& b, float margin_m, Manifold& out) noexcept;

// Two oriented boxes: separating axis test, then the incident face is clipped (Gottschalk 1996; Catto 2006).
struct OrientedBox {
  Vec3 centre_m = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
  Vec3 half_m = Vec3::Zero();
};
void collide_boxes(const OrientedBox& a, const OrientedBox& b, float margin_m, Manifold& out) noexcept;

}  // namespace thimble::control
