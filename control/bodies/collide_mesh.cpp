// A convex solid and the triangles of a mesh.
//
// The tree is walked from the nodes that the solid reaches deepest into, at most kMaxMeshNodes nodes and kMaxMeshTriangles
// triangles. Each triangle is met along the direction of least overlap on its free side. A contact counts only where no
// neighbour of the triangle rises in that direction: an edge or corner between level or hollow faces is no obstacle, and
// the face beyond it has a contact of its own.
//
// Of many triangles in one plane only kMaxLevel are met one by one. For all of them the corners of the solid's lowest face
// are met each by the triangle below it, and where its edge leaves the mesh the place is searched.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/bodies/convex.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxMeshNodes = 192;
constexpr int kMaxMeshTriangles = 48;
constexpr std::size_t kMaxWaiting = 48;  // nodes
constexpr int kMaxLevel = 8;             // triangles in one plane
constexpr int kMaxPassedOver = 16;       // triangles in one plane: the nodes that remain reach no deeper
constexpr int kMaxHalvings = 6;
// Sine of the angle by which a neighbour may rise in the direction of a contact: a ball that rolls over a level edge is
// nearer to it than to the face by 2e-6 of its radius there.
constexpr float kRise = 2.0e-3F;
constexpr float kLevel_m = 1.0e-6F;

struct Waiting {
  float reach_m;  // how far the solid's box reaches into the node's
  std::uint32_t child;
};

class TriangleCollision {
 public:
  TriangleCollision(const Convex& a, const MeshView& mesh, float margin_m, Manifold& out)
      : a_(a), mesh_(mesh), margin_m_(margin_m), out_(out), axes_(a.rotation.cwiseAbs()) {}

  // False when a bound was reached or triangles in one plane were passed over.
  bool collide();

 private:
  void wait(const flatbuffers::Array<std::uint16_t, 3>& lo, const flatbuffers::Array<std::uint16_t, 3>& hi,
            std::uint32_t child);
  // How far the solid, or the box about it, is from a box with the axes of the mesh; below 0 where they overlap.
  [[nodiscard]] float gap_m(const Vec3& middle_m, const Vec3& half_m) const;
  void collide_triangle(std::uint32_t triangle);
  void offer(const Convex& b, const Vec3& normal, Overlap& best) const;
  void offer_neighbours(const Convex& b, std::uint32_t triangle, float side, Overlap& best) const;
  [[nodiscard]] bool is_known(const std::array<scene::Vec3, 3>& corners) const;
  [[nodiscard]] bool is_level(std::uint32_t triangle, const Vec3& normal) const;
  [[nodiscard]] bool rises(std::uint32_t triangle, const Vec3& normal) const;
  [[nodiscard]] bool rises_round_corner(std::uint32_t triangle, std::uint32_t corner,
                                        const Vec3& normal) const;

  const Convex& a_;
  const MeshView& mesh_;
  float margin_m_;
  Manifold& out_;
  Mat3 axes_;
  std::array<Waiting, kMaxWaiting> waiting_;
  std::size_t waiting_count_ = 0;
  int level_ = 0;
  int passed_over_ = 0;
  int triangles_ = 0;
  bool all_ = true;
};

// A lambda: the heap calls it directly, not through a pointer.
constexpr auto nearer = [](const Waiting& x, const Waiting& y) { return x.reach_m < y.reach_m; };

float TriangleCollision::gap_m(const Vec3& middle_m, const Vec3& half_m) const {
  const Vec3 apart = middle_m - a_.centre_m;
  if (a_.form == CollisionForm::kBall)
    return (apart.cwiseAbs() - half_m).cwiseMax(0.0F).norm() - a_.half_m.x();
  const Vec3 along_grid = apart.cwiseAbs() - half_m - axes_ * a_.half_m;
  const Vec3 along_a = (a_.rotation.transpose() * apart).cwiseAbs() - a_.half_m - axes_.transpose() * half_m;
  return std::max(along_grid.maxCoeff(), along_a.maxCoeff());
}

void TriangleCollision::wait(const flatbuffers::Array<std::uint16_t, 3>& lo,
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
  all_ = false;
  // Of a full heap the last entry is one of the least deep ones.
  if (waiting_.back().reach_m < -gap) {
    waiting_.back() = {-gap, child};
    std::push_heap(waiting_.begin(), waiting_.end(), nearer);
  }
}

bool TriangleCollision::collide() {
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
      for (std::uint32_t i = first; i < first + triangle_count(child); ++i) {
        if (triangles_ == kMaxMeshTriangles || passed_over_ == kMaxPassedOver) return false;
        collide_triangle(i);
      }
    }
    if (!found) return all_;
  }
  return false;
}

// Whether the highest point of the triangle is the place of a contact that is found already.
bool TriangleCollision::is_known(const std::array<scene::Vec3, 3>& corners) const {
  for (std::size_t i = 0; i < out_.count; ++i) {
    const ContactPoint& found = out_.points[i];
    const Vec3 place = found.point_m + (0.5F * found.depth_m) * found.normal;
    bool touches = false;
    bool below = true;
    for (const scene::Vec3& corner : corners) {
      const Vec3 from = to_vec(corner) - place;
      touches = touches || from.squaredNorm() < kLevel_m * kLevel_m;
      below = below && found.normal.dot(from) < kLevel_m;
    }
    if (touches && below) return true;
  }
  return false;
}

// Whether the triangle lies in the plane of contacts that are found already.
bool TriangleCollision::is_level(std::uint32_t triangle, const Vec3& normal) const {
  constexpr float kSame = 1.0F - 1.0e-6F;
  const Vec3 p = vertex(mesh_, triangle, 0);
  for (std::size_t i = 0; i < out_.count; ++i) {
    const ContactPoint& found = out_.points[i];
    if (found.normal.dot(normal) > kSame &&
        std::abs(normal.dot(p - found.point_m) - 0.5F * found.depth_m) < kLevel_m)
      return true;
  }
  return false;
}

void TriangleCollision::offer(const Convex& b, const Vec3& normal, Overlap& best) const {
  const float depth_m = depth_along(a_, b, normal);
  constexpr float kSooner_m = 2.0e-7F;
  if (depth_m >= best.depth_m - kSooner_m) return;
  best.depth_m = depth_m;
  best.normal = normal;
}

// The normals of the faces beyond the edges and at the corners: where the solid is deep below this face it is beside one of them.
void TriangleCollision::offer_neighbours(const Convex& b, std::uint32_t triangle, float side,
                                         Overlap& best) const {
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Step beyond = across(mesh_, triangle, side > 0.0F ? std::int8_t{1} : std::int8_t{-1}, edge);
    if (beyond.triangle == triangle ||
        concave(mesh_, triangle, side > 0.0F ? std::int8_t{1} : std::int8_t{-1}, beyond))
      continue;
    const Vec3 area = static_cast<float>(beyond.side) * area_normal(mesh_, beyond.triangle);
    const float length = area.norm();
    if (length > 0.0F) offer(b, area / length, best);
  }
  // A direction between the faces leads to the nearest of them, which one along a face does not.
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    const Vec3 mean = side * to_vec(mesh_.vertices[vertex_index(mesh_, triangle, corner)].pseudonormal());
    if (mean.squaredNorm() > 0.0F) offer(b, mean.normalized(), best);
  }
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

void TriangleCollision::collide_triangle(std::uint32_t triangle) {
  std::array<scene::Vec3, 3> corners;
  for (std::uint32_t i = 0; i < 3; ++i)
    corners[i] = mesh_.vertices[vertex_index(mesh_, triangle, i)].position_m();
  const Convex b = convex_hull(corners, Mat3::Identity(), Vec3::Zero());
  const Vec3 area = area_normal(mesh_, triangle);
  const float length = area.norm();
  if (!(length > 0.0F) || gap_m(b.centre_m, b.half_m) > margin_m_) return;
  Vec3 face = area / length;
  float side = 1.0F;
  if (two_sided(mesh_, triangle) && face.dot(a_.centre_m - vertex(mesh_, triangle, 0)) < 0.0F) {
    face = -face;
    side = -1.0F;
  }
  if (depth_along(a_, b, -face) < -margin_m_) return;  // behind the face
  Overlap overlap;
  overlap.depth_m = depth_along(a_, b, face);
  overlap.normal = face;
  if (overlap.depth_m < -margin_m_ || is_known(corners)) return;
  if (level_ >= kMaxLevel && is_level(triangle, face)) {
    ++passed_over_;
    all_ = false;
    return;
  }
  ++triangles_;
  constexpr float kForwards = 0.1F;
  if (a_.form != CollisionForm::kBall) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 direction = a_.rotation.col(axis);
      const float along = direction.dot(face);
      if (std::abs(along) > kForwards) offer(b, along < 0.0F ? Vec3(-direction) : direction, overlap);
    }
  }
  constexpr float kDeep_m = 3.0e-4F;
  if (overlap.depth_m > kDeep_m) offer_neighbours(b, triangle, side, overlap);
  if (overlap.depth_m < -margin_m_) return;
  if (!least_overlap(a_, b, margin_m_, overlap) || !overlap.settled) return;
  constexpr float kSame = 1.0F - 8.0e-6F;  // above what kRise lets pass between level faces
  if (overlap.normal.dot(face) > kSame) {
    overlap.normal = face;
    overlap.depth_m = depth_along(a_, b, face);
    if (is_level(triangle, face)) ++level_;
  } else if (overlap.normal.dot(face) < -kRise || rises(triangle, overlap.normal)) {
    return;
  }
  add_contacts(a_, b, overlap, margin_m_, out_);
}

// How deep a point is below the mesh, at most depth_m. False when it is apart from it by more than margin_m.
bool collide_point(const Vec3& p, float depth_m, const MeshView& mesh, float margin_m, const Vec3& normal,
                   ContactPoint& out) {
  Manifold found;
  TriangleCollision(convex_point(p, std::max(depth_m, 0.0F)), mesh, margin_m, found).collide();
  const ContactPoint* best = nullptr;
  for (std::size_t i = 0; i < found.count; ++i) {
    constexpr float kAlike = 0.9F;
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
    for (int n = 0; n < kMaxHalvings; ++n) {
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

}  // namespace

void collide_with_triangles(const Convex& a, const MeshView& mesh, float margin_m, Manifold& out) noexcept {
  Manifold found;  // of this solid alone: what it touches tells which triangles can be passed over
  const bool all = TriangleCollision(a, mesh, margin_m, found).collide();
  for (std::size_t i = 0; i < found.count; ++i) out.add_distinct(found.points[i]);
  if (all || a.form == CollisionForm::kBall) return;
  // The deepest contact of each direction, at most three.
  std::array<ContactPoint, 3> deepest;
  std::size_t count = 0;
  for (std::size_t i = 0; i < found.count; ++i) {
    const ContactPoint& each = found.points[i];
    std::size_t same = 0;
    constexpr float kSame = 0.99F;
    while (same < count && deepest[same].normal.dot(each.normal) < kSame) ++same;
    if (same < count) {
      if (deepest[same].depth_m < each.depth_m) deepest[same] = each;
    } else if (count < deepest.size()) {
      deepest[count++] = each;
    }
  }
  for (std::size_t i = 0; i < count; ++i) collide_outline(a, mesh, deepest[i], margin_m, out);
}

}  // namespace thimble::control
