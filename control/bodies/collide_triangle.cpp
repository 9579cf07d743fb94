#include "control/bodies/collide_triangle.h"

#include <algorithm>
#include <cmath>

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxMeshTriangles = 48;  // that the solid reaches
constexpr int kMaxSearches = 12;       // of the least overlap
constexpr int kMaxLevel = 8;           // triangles in one plane
constexpr int kMaxPassedOver = 16;     // triangles in one plane: the nodes that remain reach no deeper
// Sine of the angle by which a neighbour may rise in the direction of a contact: a ball that rolls over a level edge is
// nearer to it than to the face by 2e-6 of its radius there.
constexpr float kRise = 2.0e-3F;
constexpr float kLevel_m = 1.0e-6F;
// A direction is better when it saves this much.
constexpr float kSooner_m = 2.0e-7F;
// Cosines: directions that are one, and a direction of contact that is the face's (above what kRise lets pass).
constexpr float kSameLine = 1.0F - 1.0e-6F;
constexpr float kAlongFace = 1.0F - 8.0e-6F;

using TriangleCorners = std::array<scene::Vec3, 3>;

TriangleCorners corners_of(const std::array<Vec3, 3>& p) {
  TriangleCorners out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = scene::Vec3(p[i].x(), p[i].y(), p[i].z());
  return out;
}

float height_of(const std::array<Vec3, 3>& p, const Vec3& direction) {
  return std::max({direction.dot(p[0]), direction.dot(p[1]), direction.dot(p[2])});
}

}  // namespace

TriangleCollision::TriangleCollision(const Convex& a, const MeshView& mesh, const Vec3& free_m,
                                     float margin_m, Manifold& out)
    : a_(a),
      mesh_(mesh),
      margin_m_(margin_m),
      out_(out),
      free_m_(free_m),
      centre_m_(a.rotation.transpose() * (a.centre_m - a.position_m)),
      inner_m_(a.centre_m) {
  if (a.corners.empty()) return;
  float radius2 = 0.0F;
  Vec3 sum = Vec3::Zero();
  for (const scene::Vec3& corner : a.corners) {
    const Vec3 p = to_vec(corner);
    sum += p;
    radius2 = std::max(radius2, (p - centre_m_).squaredNorm());
  }
  ball_m_ = std::sqrt(radius2);
  inner_m_ = a.rotation * (sum / static_cast<float>(a.corners.size())) + a.position_m;
}

bool TriangleCollision::at_bound() const {
  return triangles_ == kMaxMeshTriangles || passed_over_ == kMaxPassedOver;
}

// Where the triangle is. False when it is outside of the box about the solid, or has no area.
bool TriangleCollision::place(std::uint32_t triangle, Face& face) const {
  face.triangle = triangle;
  for (std::uint32_t i = 0; i < 3; ++i) {
    face.p[i] = vertex(mesh_, triangle, i);
    face.of[i] = a_.rotation.transpose() * (face.p[i] - a_.position_m);
  }
  face.lo = face.of[0].cwiseMin(face.of[1]).cwiseMin(face.of[2]);
  face.hi = face.of[0].cwiseMax(face.of[1]).cwiseMax(face.of[2]);
  const Vec3 half = a_.half_m.array() + margin_m_;
  if (((face.lo - centre_m_).array() > half.array()).any() ||
      ((centre_m_ - face.hi).array() > half.array()).any())
    return false;
  const Vec3 area = (face.p[1] - face.p[0]).cross(face.p[2] - face.p[0]);
  const float length = area.norm();
  if (!(length > 0.0F)) return false;
  face.normal = area / length;
  face.side = 1.0F;
  if (two_sided(mesh_, triangle) && face.normal.dot(free_m_ - face.p[0]) < 0.0F) {
    face.normal = -face.normal;
    face.side = -1.0F;
  }
  return true;
}

// Whether the highest corner of the triangle is the place of a contact that is found already.
bool TriangleCollision::is_known(const Face& face) const {
  for (std::size_t i = 0; i < out_.count; ++i) {
    const ContactPoint& found = out_.points[i];
    const Vec3 place = found.point_m + (0.5F * found.depth_m) * found.normal;
    for (const Vec3& corner : face.p) {
      const Vec3 from = corner - place;
      if (std::abs(from.x()) < kLevel_m && from.squaredNorm() < kLevel_m * kLevel_m &&
          height_of(face.p, found.normal) - found.normal.dot(place) < kLevel_m)
        return true;
    }
  }
  return false;
}

// Whether the triangle lies in the plane of contacts that are found already.
bool TriangleCollision::is_level(const Face& face) const {
  for (std::size_t i = 0; i < out_.count; ++i) {
    const ContactPoint& found = out_.points[i];
    if (found.normal.dot(face.normal) > kSameLine &&
        std::abs(face.normal.dot(face.p[0] - found.point_m) - 0.5F * found.depth_m) < kLevel_m)
      return true;
  }
  return false;
}

void TriangleCollision::offer(const Face& face, const Vec3& normal, Overlap& best) const {
  const float depth_m = height_of(face.p, normal) - normal.dot(a_.farthest(-normal).at_m) + a_.radius_m;
  if (depth_m >= best.depth_m - kSooner_m) return;
  best.depth_m = depth_m;
  best.normal = normal;
}

// The normals of the faces beyond the edges and at the corners: where the solid is deep below this face it is beside one of them.
void TriangleCollision::offer_neighbours(const Face& face, Overlap& best) const {
  const auto side = static_cast<std::int8_t>(face.side > 0.0F ? 1 : -1);
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Step beyond = across(mesh_, face.triangle, side, edge);
    if (beyond.triangle == face.triangle || concave(mesh_, face.triangle, side, beyond)) continue;
    const Vec3 area = static_cast<float>(beyond.side) * area_normal(mesh_, beyond.triangle);
    const float length = area.norm();
    if (length > 0.0F) offer(face, area / length, best);
  }
  // A direction between the faces leads to the nearest of them, which one along a face does not.
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    const Vec3 mean =
        face.side * to_vec(mesh_.vertices[vertex_index(mesh_, face.triangle, corner)].pseudonormal());
    if (mean.squaredNorm() > 0.0F) offer(face, mean.normalized(), best);
  }
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
  switch (a_.form) {
    case CollisionForm::kBox: {
      const Vec3 beyond = p.cwiseAbs() - a_.shape->vector;
      return beyond[(axis + 1) % 3] <= 0.0F && beyond[(axis + 2) % 3] <= 0.0F;
    }
    case CollisionForm::kCone:
      if (sign < 0.0F) return false;
      [[fallthrough]];
    case CollisionForm::kCylinder:
      return axis == 2 && p.head<2>().squaredNorm() <= a_.shape->radius_m * a_.shape->radius_m;
    case CollisionForm::kHalfSpace:
    case CollisionForm::kBall:
    case CollisionForm::kCapsule:
    case CollisionForm::kMesh:
      break;
  }
  return false;
}

bool TriangleCollision::rises_round_corner(std::uint32_t triangle, std::uint32_t corner,
                                           const Vec3& normal) const {
  const Vec3 p = vertex(mesh_, triangle, corner);
  Corner at{triangle, corner, 1};
  for (int n = 0; n < kMaxFan; ++n) {
    const Vec3 arm = vertex(mesh_, at.triangle, next(at.corner)) - p;
    const Vec3 other = vertex(mesh_, at.triangle, previous(at.corner)) - p;
    if (normal.dot(arm) > kRise * arm.norm() || normal.dot(other) > kRise * other.norm()) return true;
    at = next_in_fan(mesh_, at);
    if (at.triangle == triangle && at.side > 0) return false;
  }
  return false;
}

// Whether the mesh goes on beyond the highest edge or corner of the triangle and rises there.
bool TriangleCollision::rises(std::uint32_t triangle, const Vec3& normal) const {
  std::array<Vec3, 3> p;
  std::array<float, 3> height;
  for (std::uint32_t i = 0; i < 3; ++i) {
    p[i] = vertex(mesh_, triangle, i);
    height[i] = normal.dot(p[i]);
  }
  const auto top =
      static_cast<std::uint32_t>(std::max_element(height.begin(), height.end()) - height.begin());
  bool level = false;
  for (const std::uint32_t edge : {top, previous(top)}) {  // the two edges at the top
    const std::uint32_t from = edge;
    const std::uint32_t to = next(edge);
    const Vec3 along = p[to] - p[from];
    const float length = along.norm();
    if (std::abs(height[to] - height[from]) > kRise * length) continue;  // it falls off
    const Step beyond = across(mesh_, triangle, 1, edge);
    level = true;
    if (beyond.triangle == triangle) continue;
    const Vec3 arm = vertex(mesh_, beyond.triangle, previous(beyond.edge)) - p[from];
    const Vec3 off = arm - (arm.dot(along) / (length * length)) * along;
    if (normal.dot(off) > kRise * off.norm()) return true;
  }
  return !level && rises_round_corner(triangle, top, normal);
}

// False when they are apart, or no direction is found. Most of what comes here is beside the solid: the first direction is
// from the triangle to the middle of the solid, along which that is seen at once.
bool TriangleCollision::search(const Face& face, Overlap& overlap) {
  if (searches_ == kMaxSearches) {
    lost_ = true;
    return false;
  }
  const TriangleCorners corners = corners_of(face.p);
  const Convex b = convex_triangle(corners);
  const Vec3 aside = a_.centre_m - nearest_on_triangle(face.p, a_.centre_m);
  if (a_.form != CollisionForm::kBox && are_apart(a_, b, aside, margin_m_)) return false;
  ++searches_;
  if (!least_overlap(a_, b, margin_m_, overlap)) return false;
  lost_ = lost_ || !overlap.settled;
  return overlap.settled;
}

// Whether only one corner of the triangle can touch along the normal.
bool TriangleCollision::is_alone(const Face& face, const Overlap& overlap) const {
  const float top_m = height_of(face.p, overlap.normal);
  int near = 0;
  for (const Vec3& corner : face.p) {
    if (overlap.normal.dot(corner) > top_m - std::max(overlap.depth_m, 0.0F) - margin_m_ - kLevel_m) ++near;
  }
  return near == 1;
}

// corner: a corner of the triangle touches a flat face of the solid.
void TriangleCollision::add(const Face& face, Overlap& overlap, bool corner) {
  if (overlap.normal.dot(face.normal) > kAlongFace) {
    overlap.normal = face.normal;
    if (is_level(face)) ++level_;
  } else if (overlap.normal.dot(face.normal) < -kRise || rises(face.triangle, overlap.normal)) {
    return;
  }

  // One point where the other corners are out of reach.
  if (corner && is_alone(face, overlap)) {
    out_.add_distinct(
        {overlap.of_core_m + (0.5F * overlap.depth_m) * overlap.normal, overlap.normal, overlap.depth_m});
    return;
  }
  const TriangleCorners corners = corners_of(face.p);
  add_contacts(a_, convex_triangle(corners), overlap, margin_m_, out_);
}

// A ball or capsule: what is nearest to its core. Where the core goes through the triangle's plane, the face pushes it out.
void TriangleCollision::collide_round(const Face& face, float depth_m, const Vec3& lowest_m) {
  Overlap overlap;
  overlap.of_core_m = lowest_m;
  overlap.normal = face.normal;
  overlap.depth_m = depth_m;
  if (!is_over(face, lowest_m)) {
    NearestPair pair;
    if (a_.form == CollisionForm::kBall) {
      pair.of_a_m = lowest_m;
      pair.apart_m = lowest_m - nearest_on_triangle(face.p, lowest_m);
    } else {
      const TriangleCorners corners = corners_of(face.p);
      const Distance distance =
          nearest_points(a_, convex_triangle(corners), Vec3::Zero(), face.normal, margin_m_, pair);
      if (distance == Distance::kApart) return;
      if (distance == Distance::kTouching) pair.apart_m = Vec3::Zero();
    }
    const float apart_m = pair.apart_m.norm();
    const bool above = pair.apart_m.dot(face.normal) > 0.0F;
    if (!above && a_.form == CollisionForm::kBall) return;
    if (above) {
      overlap.of_core_m = pair.of_a_m;
      overlap.normal = pair.apart_m / apart_m;
      overlap.depth_m = a_.radius_m - apart_m;
      if (overlap.depth_m < -margin_m_) return;
    }
  }
  add(face, overlap, false);
}

// The least overlap along the face's normal and those axes of the solid that point to the free side.
// lowest_m: the place of the solid's core that is farthest against the normal; depth_m: how deep it is below the plane.
TriangleCollision::Guess TriangleCollision::along_axes(const Face& face, float depth_m) const {
  constexpr float kForwards = 0.1F;
  Guess guess;
  guess.depth_m = depth_m;
  for (int axis = 0; axis < 3; ++axis) {
    const float along = a_.rotation.col(axis).dot(face.normal);
    if (std::abs(along) <= kForwards) continue;
    const float sign = std::copysign(1.0F, along);
    if (std::abs(along) > kSameLine) guess.level = axis;
    const float reach = along > 0.0F ? face.hi[axis] - centre_m_[axis] : centre_m_[axis] - face.lo[axis];
    const float depth = reach + a_.half_m[axis];
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
    const float sign = std::copysign(1.0F, a_.rotation.col(guess.level).dot(face.normal));
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
// face's normal separates, overlaps (Gottschalk 1996). kLeast: two edges cross, and no direction has less overlap.
TriangleCollision::Verdict TriangleCollision::along_edges(const Face& face, Overlap& overlap) const {
  const Vec3& half = a_.shape->vector;
  const Vec3 normal = a_.rotation.transpose() * face.normal;
  Verdict verdict = Verdict::kOpen;
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
      if (depth_m >= overlap.depth_m - kSooner_m || opposite > of_edge) continue;
      // Where the edges cross, seen along the axis of the box.
      Vec3 p;
      p[u] = -std::copysign(half[u], across[u]);
      p[v] = -std::copysign(half[v], across[v]);
      const float part = ((p[u] - from[u]) * edge[u] + (p[v] - from[v]) * edge[v]) / across2;
      p[axis] = from[axis] + part * edge[axis];
      overlap.normal = a_.rotation * (across / length);
      overlap.depth_m = depth_m;
      overlap.of_core_m = a_.rotation * p + a_.position_m;
      verdict =
          part >= 0.0F && part <= 1.0F && std::abs(p[axis]) <= half[axis] ? Verdict::kLeast : Verdict::kOpen;
    }
  }
  return verdict;
}

void TriangleCollision::collide_flat(const Face& face, const Guess& guess, const Vec3& lowest_m) {
  Overlap overlap;
  overlap.depth_m = guess.depth_m;
  overlap.normal = guess.axis < 0 ? face.normal : Vec3(guess.sign * a_.rotation.col(guess.axis));
  constexpr float kDeep_m = 3.0e-4F;
  if (overlap.depth_m > kDeep_m) offer_neighbours(face, overlap);
  if (overlap.depth_m < -margin_m_) return;
  if (overlap.depth_m == guess.depth_m && is_least(face, guess, lowest_m, overlap))
    return add(face, overlap, guess.axis >= 0);
  if (a_.form == CollisionForm::kBox) {
    const Verdict verdict = along_edges(face, overlap);
    if (verdict == Verdict::kApart) return;
    if (verdict == Verdict::kLeast) return add(face, overlap, false);
  }
  if (search(face, overlap)) add(face, overlap, false);
}

void TriangleCollision::collide(std::uint32_t triangle) {
  Face face;
  if (!place(triangle, face)) return;
  // Of a hull each farthest point costs a product per corner: first the ball about it.
  if (a_.form == CollisionForm::kMesh && face.normal.dot(face.p[0] - a_.centre_m) + ball_m_ < -margin_m_)
    return;
  const Vec3 lowest_m = a_.farthest(-face.normal).at_m;
  const float depth_m = face.normal.dot(face.p[0] - lowest_m) + a_.radius_m;
  if (depth_m < -margin_m_) return;
  // Of a point, what is within its reach is not behind the face.
  const float above_m = a_.form == CollisionForm::kBall ? a_.half_m.x() : a_.radius_m;
  if (depth_m > margin_m_ && face.normal.dot(inner_m_ - face.p[0]) < 0.0F &&
      face.normal.dot(a_.farthest(face.normal).at_m - face.p[0]) + above_m < -margin_m_)
    return;  // behind the face
  const bool round = a_.form == CollisionForm::kBall || a_.form == CollisionForm::kCapsule;
  const Guess guess = round ? Guess{.depth_m = depth_m} : along_axes(face, depth_m);
  if (guess.depth_m < -margin_m_ || is_known(face)) return;
  if (level_ >= kMaxLevel && is_level(face)) {
    ++passed_over_;
    met_all_ = false;
    return;
  }
  if (triangles_ == kMaxMeshTriangles) {
    lost_ = true;
    return;
  }
  ++triangles_;
  normals_ += face.normal;
  if (round) return collide_round(face, depth_m, lowest_m);
  collide_flat(face, guess, lowest_m);
}

}  // namespace thimble::control
