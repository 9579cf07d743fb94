// Closed forms of TriangleCollision: the least overlap along the axes of a solid, across its edges and at a corner of the
// triangle.
#include <algorithm>
#include <cmath>

#include "control/bodies/collide_triangle.h"

namespace thimble::control {

float TriangleCollision::height_of(const std::array<Vec3, 3>& p, const Vec3& direction) {
  return std::max({direction.dot(p[0]), direction.dot(p[1]), direction.dot(p[2])});
}

// Whether p is above the triangle or below it, along its normal.
bool TriangleCollision::is_over(const Face& face, const Vec3& p) const {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 along = face.p[i == 2 ? 0 : i + 1] - face.p[i];
    if (face.side * face.normal.dot(along.cross(p - face.p[i])) < 0.0F) return false;
  }
  return true;
}

// Whether the solid is flat where it is farthest against one of its axes (sign 1) or along it (-1), and a point of its frame
// is above or below that face.
bool TriangleCollision::is_under_face(const Vec3& p, int axis, float sign) const {
  switch (a_->form) {
    case CollisionForm::kBox: {
      const Vec3 beyond = p.cwiseAbs() - a_->shape->vector;
      return beyond[(axis + 1) % 3] <= 0.0F && beyond[(axis + 2) % 3] <= 0.0F;
    }
    case CollisionForm::kCone:
      if (sign < 0.0F) return false;
      [[fallthrough]];
    case CollisionForm::kCylinder:
      return axis == 2 && p.head<2>().squaredNorm() <= a_->shape->radius_m * a_->shape->radius_m;
    case CollisionForm::kHalfSpace:
    case CollisionForm::kBall:
    case CollisionForm::kCapsule:
    case CollisionForm::kMesh:
      break;
  }
  return false;
}

// The least overlap along the face's normal and those axes of the solid that point to the free side.
// lowest_m: the place of the solid's core that is farthest against the normal; depth_m: how deep it is below the plane.
TriangleCollision::Guess TriangleCollision::along_axes(const Face& face, float depth_m) const {
  constexpr float kForwards = 0.1F;
  Guess guess;
  guess.depth_m = depth_m;
  for (int axis = 0; axis < 3; ++axis) {
    const float along = a_->rotation.col(axis).dot(face.normal);
    if (std::abs(along) <= kForwards) continue;
    const float sign = std::copysign(1.0F, along);
    if (std::abs(along) > kSameLine) guess.level = axis;
    const float reach = along > 0.0F ? face.hi[axis] - centre_m_[axis] : centre_m_[axis] - face.lo[axis];
    const float depth = reach + a_->half_m[axis];
    if (depth >= guess.depth_m - kSooner_m) continue;
    guess.depth_m = depth;
    guess.axis = axis;
    guess.sign = sign;
  }
  return guess;
}

// Whether no neighbouring direction has less overlap; then of_core_m is set.
bool TriangleCollision::is_least(const Face& face, const Guess& guess, const Vec3& lowest_m,
                                 Overlap& overlap) const {
  if (guess.axis < 0) {
    overlap.of_core_m = lowest_m;
    if (is_over(face, lowest_m)) return true;
    if (guess.level < 0) return false;
    const float sign = std::copysign(1.0F, a_->rotation.col(guess.level).dot(face.normal));
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_under_face(face.of[i], guess.level, sign)) continue;
      overlap.of_core_m = face.p[i] - overlap.depth_m * overlap.normal;
      return true;
    }
    return false;
  }
  std::size_t top = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (guess.sign * face.of[i][guess.axis] > guess.sign * face.of[top][guess.axis]) top = i;
  overlap.of_core_m = face.p[top] - overlap.depth_m * overlap.normal;
  return is_under_face(face.of[top], guess.axis, guess.sign);
}

// A box: the directions across an edge of it and one of the triangle. What no direction of these, of its axes and of the
// face's normal separates, overlaps (Gottschalk 1996). kLeast: two edges cross, no neighbouring direction has less overlap,
// and the mesh does not go on in that direction.
TriangleCollision::Verdict TriangleCollision::along_edges(const Face& face, Overlap& overlap) const {
  const Vec3& half = a_->shape->vector;
  const Vec3 normal = a_->rotation.transpose() * face.normal;
  // A crossing far deeper than other directions is one of an edge beyond them.
  constexpr float kRoom_m = 3.0e-4F;
  Overlap crossed;
  crossed.depth_m = overlap.depth_m + kRoom_m;
  bool found = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = face.of[i];
    const Vec3 edge = face.of[i == 2 ? 0 : i + 1] - from;
    const float edge2 = edge.squaredNorm();
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      Vec3 across = Vec3::Zero();
      across[u] = -edge[v];
      across[v] = edge[u];
      if (across.dot(normal) < 0.0F) across = -across;
      const float across2 = across.squaredNorm();
      constexpr float kLeastSine2 = 1.0e-4F;
      if (across2 < kLeastSine2 * edge2) continue;
      const float length = std::sqrt(across2);
      const float of_edge = across.dot(from);
      const float opposite = across.dot(face.of[i == 0 ? 2 : i - 1]);
      const float depth_m = (std::max(of_edge, opposite) + across.cwiseAbs().dot(half)) / length;
      if (depth_m < -margin_m_) return Verdict::kApart;
      if (depth_m >= crossed.depth_m - kSooner_m || opposite > of_edge) continue;
      // Where the edges cross, seen along the axis of the box.
      Vec3 p;
      p[u] = -std::copysign(half[u], across[u]);
      p[v] = -std::copysign(half[v], across[v]);
      const float part = ((p[u] - from[u]) * edge[u] + (p[v] - from[v]) * edge[v]) / across2;
      p[axis] = from[axis] + part * edge[axis];
      const bool least = part >= 0.0F && part <= 1.0F && std::abs(p[axis]) <= half[axis];
      Overlap& into = least ? crossed : overlap;
      if (depth_m >= into.depth_m - kSooner_m) continue;
      const Vec3 along = a_->rotation * (across / length);
      if (least && rises(face.triangle, along)) continue;
      found = found || least;
      into.normal = along;
      into.depth_m = depth_m;
      into.of_core_m = a_->rotation * p + a_->position_m;
    }
  }
  if (!found) return Verdict::kOpen;
  overlap = crossed;
  return Verdict::kLeast;
}

// The corner of the triangle that is deepest in the solid, or nearest to it, along the solid's normal there. kLeast: the other
// corners are below it, so no neighbouring direction has less overlap.
TriangleCollision::Verdict TriangleCollision::at_corner(const Face& face, Overlap& overlap) const {
  if (a_->nearest == nullptr) return Verdict::kOpen;
  NearestPlace place = a_->nearest(*a_->shape, face.of[0]);
  std::size_t at = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    const NearestPlace other = a_->nearest(*a_->shape, face.of[i]);
    if (other.outside_m >= place.outside_m) continue;
    place = other;
    at = i;
  }
  const Vec3 normal = a_->rotation * -place.normal;
  const float above_m = height_of(face.p, normal) - normal.dot(face.p[at]);
  const float depth_m = above_m - place.outside_m;
  if (depth_m < -margin_m_) return Verdict::kApart;
  if (depth_m >= overlap.depth_m - kSooner_m) return Verdict::kOpen;
  overlap.depth_m = depth_m;
  overlap.normal = normal;
  overlap.of_core_m = face.p[at] + (a_->radius_m - depth_m) * normal;
  return above_m > 0.0F ? Verdict::kOpen : Verdict::kLeast;
}

}  // namespace thimble::control
