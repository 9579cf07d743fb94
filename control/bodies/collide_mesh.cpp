// A convex solid and the triangles of a mesh.
//
// The tree is walked from the nodes that the solid reaches deepest into, at most kMaxMeshNodes nodes. Each triangle is met
// by itself (control/bodies/collide_triangle.h).
//
// Of many triangles in one plane only some are met one by one. For all of them, and for triangles that are left out at a
// bound, the corners of the solid's lowest face are met each by the triangle below it, and where its edge leaves the mesh
// the place is searched.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "control/bodies/collide_triangle.h"
#include "control/bodies/convex.h"
#include "control/scene/mesh_leaf.h"

namespace thimble::control {
namespace {

constexpr int kMaxMeshNodes = 320;
constexpr std::size_t kMaxWaiting = 96;  // nodes
constexpr int kMaxSplits = 6;

struct Waiting {
  float reach_m;  // how far the solid's box reaches into the node's
  std::uint32_t child;
};

class MeshWalk {
 public:
  MeshWalk(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m, Manifold& out);

  // Meets the triangles; says how many were left out.
  const TriangleCollision& collide() {
    walk();
    triangles_.finish();
    return triangles_;
  }
  // Whether nodes were left out at a bound.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  void walk();
  void wait(const flatbuffers::Array<std::uint16_t, 3>& lo, const flatbuffers::Array<std::uint16_t, 3>& hi,
            std::uint32_t child);
  // How far the solid, or the box about it, is from a box with the axes of the mesh; below 0 where they overlap.
  [[nodiscard]] float gap_m(const Vec3& middle_m, const Vec3& half_m) const;

  const Convex& a_;
  const MeshView& mesh_;
  float margin_m_;
  Mat3 axes_;
  Vec3 box_m_;  // half of a box with the axes of the mesh about the solid
  TriangleCollision triangles_;
  float ball_m_;  // of a ball or hull: radius of the ball round the centre about it
  std::array<Waiting, kMaxWaiting> waiting_;
  std::size_t waiting_count_ = 0;
  bool lost_ = false;
};

// A lambda: the heap calls it directly, not through a pointer.
constexpr auto nearer = [](const Waiting& x, const Waiting& y) { return x.reach_m < y.reach_m; };

MeshWalk::MeshWalk(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m, Manifold& out)
    : a_(a),
      mesh_(mesh),
      margin_m_(margin_m),
      axes_(a.rotation.cwiseAbs()),
      box_m_(axes_ * a.half_m),
      triangles_(a, mesh, free_m, margin_m, out),
      ball_m_(a.form == CollisionForm::kBall ? a.half_m.x() : triangles_.ball_m()) {}

float MeshWalk::gap_m(const Vec3& middle_m, const Vec3& half_m) const {
  const Vec3 apart = middle_m - a_.centre_m;
  const Vec3 beyond = apart.cwiseAbs() - half_m;
  float gap = -box_m_.sum();
  if (ball_m_ > 0.0F) {
    gap = beyond.cwiseMax(0.0F).norm() - ball_m_;
    if (a_.form == CollisionForm::kBall || gap > margin_m_) return gap;
  }
  gap = std::max(gap, (beyond - box_m_).maxCoeff());
  if (gap > margin_m_) return gap;
  const Vec3 along_a = (a_.rotation.transpose() * apart).cwiseAbs() - a_.half_m - axes_.transpose() * half_m;
  gap = std::max(gap, along_a.maxCoeff());
  if (gap > margin_m_ || a_.form == CollisionForm::kBox || a_.nearest == nullptr) return gap;
  // A round solid does not fill the box about it: along its normal at the place that is nearest to the node's middle.
  const NearestPlace place = a_.nearest(*a_.shape, a_.rotation.transpose() * (middle_m - a_.position_m));
  return std::max(gap, place.outside_m - half_m.dot((a_.rotation * place.normal).cwiseAbs()));
}

void MeshWalk::wait(const flatbuffers::Array<std::uint16_t, 3>& lo,
                    const flatbuffers::Array<std::uint16_t, 3>& hi, std::uint32_t child) {
  const Vec3 low(static_cast<float>(lo[0]), static_cast<float>(lo[1]), static_cast<float>(lo[2]));
  const Vec3 high(static_cast<float>(hi[0]), static_cast<float>(hi[1]), static_cast<float>(hi[2]));
  const float half_step_m = 0.5F * mesh_.grid_step_m;
  const float gap = gap_m(half_step_m * (high + low) + mesh_.grid_origin_m, half_step_m * (high - low));
  if (gap > margin_m_) return;
  if (waiting_count_ < waiting_.size()) {
    waiting_[waiting_count_++] = {-gap, child};
    std::push_heap(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), nearer);
    return;
  }
  lost_ = true;
  // Of a full heap the last entry is one of the least deep ones.
  if (waiting_.back().reach_m < -gap) {
    waiting_.back() = {-gap, child};
    std::push_heap(waiting_.begin(), waiting_.end(), nearer);
  }
}

void MeshWalk::walk() {
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxMeshNodes; ++visits) {
    const scene::BvhNode& node = mesh_.nodes[at];
    wait(*node.lo_a(), *node.hi_a(), (*node.child())[0]);
    if ((*node.child())[1] != (*node.child())[0]) wait(*node.lo_b(), *node.hi_b(), (*node.child())[1]);
    // Leaves in a row, up to the next inner node.
    bool found = false;
    for (std::size_t left = waiting_count_; left > 0 && !found; --left) {
      std::pop_heap(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), nearer);
      const std::uint32_t child = waiting_[--waiting_count_].child;
      if (!is_leaf(child)) {
        at = child;
        found = true;
        continue;
      }
      const std::uint32_t first = first_triangle(child);
      for (std::uint32_t i = first; i < first + triangle_count(child); ++i) triangles_.collide(i);
      if (!triangles_.at_bound()) continue;
      lost_ = waiting_count_ > 0 && !triangles_.passed_over();
      return;
    }
    if (!found) return;
  }
  lost_ = true;
}

// How deep a point is below the mesh, at most depth_m. False when it is apart from it by more than margin_m.
bool collide_point(const Vec3& p, float depth_m, const MeshView& mesh, float margin_m, const Vec3& normal,
                   ContactPoint& out) {
  Manifold found;
  const Convex at = convex_point(p, std::max(depth_m, 0.0F));
  constexpr float kFree_m = 1.0F;
  MeshWalk(at, mesh, p + kFree_m * normal, margin_m, found).collide();
  const ContactPoint* best = nullptr;
  for (std::size_t i = 0; i < found.count; ++i) {
    constexpr float kAlike = 0.5F;
    const ContactPoint& each = found.points[i];
    if (each.normal.dot(normal) > kAlike && (best == nullptr || each.depth_m > best->depth_m)) best = &each;
  }
  if (best == nullptr) return false;
  out = *best;
  return true;
}

// The corners of the face of `a` that is farthest against the normal, and where its edges leave the mesh.
void collide_outline(const Convex& a, const MeshView& mesh, const ContactPoint& deepest, float margin_m,
                     Manifold& out) {
  // The deepest place may be on a curved face or on a bump that no corner of the face reaches.
  constexpr float kRoom_m = 1.0e-4F;
  const float depth_m = deepest.depth_m + kRoom_m;
  Outline face;
  a.outline(-deepest.normal, std::max(deepest.depth_m, 0.0F) + margin_m, face);
  std::array<bool, kMaxManifold> held{};
  const std::size_t corners = std::min(face.count, held.size());
  const auto surface = [&](const Vec3& p) { return Vec3(p - a.radius_m * deepest.normal); };
  ContactPoint point;
  for (std::size_t i = 0; i < corners; ++i) {
    held[i] = collide_point(surface(face.corner[i]), depth_m, mesh, margin_m, deepest.normal, point);
    if (held[i]) out.add_distinct(point);
  }
  for (std::size_t i = 0; i < corners; ++i) {
    const std::size_t j = i + 1 == corners ? 0 : i + 1;
    if (held[i] == held[j]) continue;
    Vec3 on = face.corner[held[i] ? i : j];
    Vec3 off = face.corner[held[i] ? j : i];
    bool any = false;
    for (int n = 0; n < kMaxSplits; ++n) {
      const Vec3 middle = 0.5F * (on + off);
      ContactPoint there;
      if (collide_point(surface(middle), depth_m, mesh, margin_m, deepest.normal, there)) {
        on = middle;
        point = there;
        any = true;
      } else {
        off = middle;
      }
    }
    if (any) out.add_distinct(point);
  }
}

// A contact that the solid's middle is behind counts only where no other holds it: else it is the far side of a plate.
void drop_far_sides(const Vec3& middle_m, Manifold& found) {
  std::size_t front = 0;
  for (std::size_t i = 0; i < found.count; ++i) {
    const ContactPoint& p = found.points[i];
    if (p.normal.dot(middle_m - p.point_m) > 0.0F) found.points[front++] = p;
  }
  if (front > 0) found.count = front;
}

// The corners of the solid's lowest face for each direction of contact.
void collide_outlines(const Convex& a, const MeshView& mesh, const TriangleCollision& triangles, bool lost,
                      const Manifold& found, float margin_m, Manifold& out) {
  // The deepest contact of each direction, at most three.
  std::array<ContactPoint, 3> deepest;
  std::size_t count = 0;
  for (std::size_t i = 0; i < found.count; ++i) {
    const ContactPoint& each = found.points[i];
    std::size_t same = 0;
    constexpr float kSame = 0.99F;
    while (same < count && deepest[same].normal.dot(each.normal) < kSame) ++same;
    if (same == deepest.size() || (same < count && deepest[same].depth_m >= each.depth_m)) continue;
    deepest[same] = each;
    count = std::max(count, same + 1);
  }
  // Where no triangle that was met holds the solid off the mesh, one that was left out may.
  constexpr float kReach_m = 1.0e-3F;
  constexpr float kOff = 0.7F;
  if (const float length = triangles.normals().norm(); lost && length > 0.0F) {
    const ContactPoint off{a.centre_m, triangles.normals() / length, kReach_m};
    bool held = false;
    for (std::size_t i = 0; i < count; ++i) held = held || deepest[i].normal.dot(off.normal) > kOff;
    if (!held) deepest[count == deepest.size() ? count - 1 : count++] = off;
  }
  for (std::size_t i = 0; i < count; ++i) collide_outline(a, mesh, deepest[i], margin_m, out);
}

}  // namespace

void collide_with_triangles(const Convex& a, const MeshView& mesh, float margin_m, Manifold& out) noexcept {
  Manifold found;  // of this solid alone: what it touches tells which triangles can be passed over
  MeshWalk walk(a, mesh, a.centre_m, margin_m, found);
  const TriangleCollision& triangles = walk.collide();
  const bool lost = walk.lost() || triangles.lost();
  drop_far_sides(a.centre_m, found);
  if (lost) ++out.left_out;
  if ((!triangles.met_all() || lost) && a.form != CollisionForm::kBall)
    collide_outlines(a, mesh, triangles, lost, found, margin_m, out);
  // After the corners, which are the same ones in each tick.
  for (std::size_t i = 0; i < found.count; ++i) out.add_distinct(found.points[i]);
}

}  // namespace thimble::control
