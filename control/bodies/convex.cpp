#include "control/bodies/convex.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace thimble::control {
namespace {

constexpr std::size_t kCornersPerUnit = 8;  // of work

// Apex and base of a cone (control/solids/cone.cpp).
float apex_m(const ShapeData& shape) { return 1.5F * shape.half_height_m; }
float base_m(const ShapeData& shape) { return -0.5F * shape.half_height_m; }

// Across the z axis, x where the direction is along z.
Vec3 across_axis(const Vec3& direction) {
  const float length = planar_length(direction.x(), direction.y());
  constexpr float kUpright = 1.0e-6F;
  return length > kUpright ? Vec3(direction.x() / length, direction.y() / length, 0.0F) : Vec3(Vec3::UnitX());
}

Vec3 farthest_of_cone(const ShapeData& shape, const Vec3& direction) {
  const Vec3 out = across_axis(direction);
  const Vec3 rim(shape.radius_m * out.x(), shape.radius_m * out.y(), base_m(shape));
  const Vec3 apex(0.0F, 0.0F, apex_m(shape));
  return direction.dot(apex) > direction.dot(rim) ? apex : rim;
}

void add_round_face(const Convex& of, const Vec3& direction, float z, Outline& out) {
  constexpr float kHalf = 0.70710678F;
  const Vec3 first = across_axis(direction);
  const Vec3 second(-first.y(), first.x(), 0.0F);
  const std::array<std::pair<float, float>, 8> parts = {
      {{1, 0}, {kHalf, kHalf}, {0, 1}, {-kHalf, kHalf}, {-1, 0}, {-kHalf, -kHalf}, {0, -1}, {kHalf, -kHalf}}};
  for (const auto& [x, y] : parts) {
    const Vec3 p = of.shape->radius_m * (x * first + y * second);
    out.add(of.rotation * Vec3(p.x(), p.y(), z) + of.position_m);
  }
}

void outline_of_box(const Convex& of, const Vec3& local, Outline& out) {
  Eigen::Index k = 0;
  local.cwiseAbs().maxCoeff(&k);
  const Vec3& half = of.shape->vector;
  const Eigen::Index u = (k + 1) % 3;
  const Eigen::Index v = (k + 2) % 3;
  const std::array<std::pair<float, float>, 4> parts = {{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  for (const auto& [x, y] : parts) {
    Vec3 p;
    p[k] = std::copysign(half[k], local[k]);
    p[u] = x * half[u];
    p[v] = y * half[v];
    out.add(of.rotation * p + of.position_m);
  }
}

// The corners within depth_m of the farthest one, in order round the direction; the farthest ones when there are more than
// an outline holds.
void outline_of_hull(const Convex& of, const Vec3& local, float depth_m, Outline& out) {
  struct Found {
    Vec3 at;
    float height;
    float angle;
  };
  std::array<Found, kMaxManifold> found;
  std::size_t count = 0;
  float top = -std::numeric_limits<float>::infinity();
  for (const scene::Vec3& corner : of.corners) top = std::max(top, local.dot(to_vec(corner)));
  for (const scene::Vec3& corner : of.corners) {
    const Vec3 p = to_vec(corner);
    const float height = local.dot(p);
    if (height < top - depth_m) continue;
    if (count < found.size()) {
      found[count++] = {p, height, 0.0F};
      continue;
    }
    const auto lowest = std::min_element(found.begin(), found.end(),
                                         [](const Found& x, const Found& y) { return x.height < y.height; });
    if (lowest->height < height) *lowest = {p, height, 0.0F};
  }
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) middle += found[i].at;
  middle /= static_cast<float>(count);
  const Vec3 u = local.unitOrthogonal();
  const Vec3 v = local.cross(u);
  for (std::size_t i = 0; i < count; ++i) {
    // Rises with the angle, from -2 to 2.
    const float x = u.dot(found[i].at - middle);
    const float y = v.dot(found[i].at - middle);
    const float length = std::abs(x) + std::abs(y);
    const float part = length > 0.0F ? x / length : 0.0F;
    found[i].angle = y < 0.0F ? part - 1.0F : 1.0F - part;
  }
  for (std::size_t i = 1; i < count; ++i) {
    for (std::size_t k = i; k > 0 && found[k].angle < found[k - 1].angle; --k)
      std::swap(found[k], found[k - 1]);
  }
  for (std::size_t i = 0; i < count; ++i) out.add(of.rotation * found[i].at + of.position_m);
}

// The round face where the direction is nearer to the axis than to the side, the line of the side otherwise.
void outline_of_cylinder(const Convex& of, const Vec3& local, Outline& out) {
  constexpr float kSlant = 0.70710678F;
  const float half = of.shape->half_height_m;
  if (std::abs(local.z()) > kSlant) return add_round_face(of, local, std::copysign(half, local.z()), out);
  const Vec3 side = of.shape->radius_m * across_axis(local);
  out.add(of.rotation * Vec3(side.x(), side.y(), half) + of.position_m);
  out.add(of.rotation * Vec3(side.x(), side.y(), -half) + of.position_m);
}

void outline_of_cone(const Convex& of, const Vec3& local, Outline& out) {
  const ShapeData& shape = *of.shape;
  const Vec3 side = across_axis(local);
  // The side's unit normal is (vector.x across the axis, vector.y along it).
  const float along_side = shape.vector.x() * local.dot(side) + shape.vector.y() * local.z();
  if (-local.z() > along_side) return add_round_face(of, local, base_m(shape), out);
  out.add(of.rotation * Vec3(0.0F, 0.0F, apex_m(shape)) + of.position_m);
  out.add(of.rotation * Vec3(shape.radius_m * side.x(), shape.radius_m * side.y(), base_m(shape)) +
          of.position_m);
}

}  // namespace

FarPoint Convex::farthest(const Vec3& direction) const noexcept {
  if (work != nullptr) work->charge(1 + static_cast<std::uint32_t>(corners.size() / kCornersPerUnit));
  if (form == CollisionForm::kBall) return {position_m};
  const Vec3 local = placed ? Vec3(rotation.transpose() * direction) : direction;
  FarPoint far{Vec3::Zero()};
  switch (form) {
    case CollisionForm::kHalfSpace:
    case CollisionForm::kBall:
      return {position_m};
    case CollisionForm::kCapsule:
      far.at_m.z() = std::copysign(shape->half_height_m, local.z());
      break;
    case CollisionForm::kBox:
      for (int i = 0; i < 3; ++i) far.at_m[i] = std::copysign(shape->vector[i], local[i]);
      break;
    case CollisionForm::kCylinder:
      far.at_m = shape->radius_m * across_axis(local);
      far.at_m.z() = std::copysign(shape->half_height_m, local.z());
      break;
    case CollisionForm::kCone:
      far.at_m = farthest_of_cone(*shape, local);
      break;
    case CollisionForm::kMesh: {
      float best = -std::numeric_limits<float>::infinity();
      std::size_t at = 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const float height = local.dot(to_vec(corners[i]));
        if (height > best) {
          best = height;
          at = i;
        }
      }
      far = {to_vec(corners[at]), static_cast<std::uint8_t>(at)};
      break;
    }
  }
  if (placed) far.at_m = rotation * far.at_m + position_m;
  return far;
}

void Convex::outline(const Vec3& direction, float depth_m, Outline& out) const noexcept {
  out.count = 0;
  // Of a hull: two passes over the corners, and the order of those that are found.
  if (work != nullptr) work->charge(3 + static_cast<std::uint32_t>(2 * corners.size() / kCornersPerUnit));
  const Vec3 local = rotation.transpose() * direction;
  switch (form) {
    case CollisionForm::kHalfSpace:
    case CollisionForm::kBall:
      out.add(position_m);
      break;
    case CollisionForm::kCapsule:
      out.add(position_m + shape->half_height_m * rotation.col(2));
      out.add(position_m - shape->half_height_m * rotation.col(2));
      break;
    case CollisionForm::kBox:
      outline_of_box(*this, local, out);
      break;
    case CollisionForm::kCylinder:
      outline_of_cylinder(*this, local, out);
      break;
    case CollisionForm::kCone:
      outline_of_cone(*this, local, out);
      break;
    case CollisionForm::kMesh:
      outline_of_hull(*this, local, depth_m, out);
      break;
  }
}

Convex convex_solid(const PlacedObject& object, const Mat3& rotation, const Vec3& position_m) noexcept {
  Convex convex;
  convex.form = object.row->collision->form;
  convex.shape = &object.shape;
  convex.nearest = object.row->collision->nearest;
  convex.rotation = rotation;
  convex.position_m = position_m;
  convex.centre_m = position_m;
  if (convex.form == CollisionForm::kBall || convex.form == CollisionForm::kCapsule) {
    convex.radius_m = object.shape.radius_m;
    convex.half_m = Vec3::Constant(convex.radius_m);
    if (convex.form == CollisionForm::kCapsule) convex.half_m.z() += object.shape.half_height_m;
  } else {
    const BoxAbout box = object.row->collision->box_about(object.shape);
    convex.centre_m += rotation * box.centre_m;
    convex.half_m = box.half_m;
  }
  return convex;
}

Convex convex_hull(std::span<const scene::Vec3> corners, const Mat3& rotation,
                   const Vec3& position_m) noexcept {
  Convex convex;
  convex.form = CollisionForm::kMesh;
  convex.corners = corners;
  convex.rotation = rotation;
  convex.position_m = position_m;
  Vec3 lo = to_vec(corners.front());
  Vec3 hi = lo;
  for (const scene::Vec3& corner : corners) {
    lo = lo.cwiseMin(to_vec(corner));
    hi = hi.cwiseMax(to_vec(corner));
  }
  convex.centre_m = rotation * (0.5F * (lo + hi)) + position_m;
  convex.half_m = 0.5F * (hi - lo);
  return convex;
}

Convex convex_triangle(std::span<const scene::Vec3> corners) noexcept {
  Convex convex;
  convex.form = CollisionForm::kMesh;
  convex.corners = corners;
  convex.placed = false;
  return convex;
}

Convex convex_point(const Vec3& position_m, float reach_m) noexcept {
  Convex convex;
  convex.position_m = convex.centre_m = position_m;
  convex.half_m = Vec3::Constant(reach_m);
  return convex;
}

}  // namespace thimble::control
