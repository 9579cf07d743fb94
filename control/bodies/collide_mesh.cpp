// A convex solid and the triangles of a mesh.
//
// The tree is walked from the nodes that the solid reaches deepest into, at most kMaxMeshNodes nodes. Each triangle is met
// by itself (control/bodies/collide_triangle.h).
//
// Of many triangles in one plane only some are met one by one. For all of them, and for triangles that are left out at a
// bound, the corners of the solid's lowest face are met each by the triangle below it, and where its edge leaves the mesh
// the place is searched.
#include "control/bodies/collide_mesh.h"

#include <algorithm>
#include <cmath>

#include "control/scene/mesh_leaf.h"

namespace thimble::control {
namespace {

constexpr int kMaxMeshNodes = 320;
constexpr int kMaxSplits = 6;

// A lambda: the heap calls it directly, not through a pointer.
constexpr auto nearer = [](const auto& x, const auto& y) { return x.reach_m < y.reach_m; };

// A contact that the solid's middle is behind counts only where no other holds it: else it is the far side of a plate.
void drop_far_sides(const Vec3& middle_m, Manifold& found) {
  std::size_t front = 0;
  for (std::size_t i = 0; i < found.count; ++i) {
    const ContactPoint& p = found.points[i];
    if (p.normal.dot(middle_m - p.point_m) > 0.0F) found.points[front++] = p;
  }
  if (front > 0) found.count = front;
}

}  // namespace

void MeshWalk::begin(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m,
                     Manifold& out) {
  a_ = &a;
  mesh_ = &mesh;
  margin_m_ = margin_m;
  axes_ = a.rotation.cwiseAbs();
  box_m_ = axes_ * a.half_m;
  triangles_.begin(a, mesh, free_m, margin_m, out);
  ball_m_ = a.form == CollisionForm::kBall ? a.half_m.x() : triangles_.ball_m();
  waiting_count_ = 0;
  node_ = triangle_ = end_ = 0;
  visits_ = 0;
  walked_ = lost_ = false;
}

float MeshWalk::gap_m(const Vec3& middle_m, const Vec3& half_m) const {
  const Vec3 apart = middle_m - a_->centre_m;
  const Vec3 beyond = apart.cwiseAbs() - half_m;
  float gap = -box_m_.sum();
  if (ball_m_ > 0.0F) {
    gap = beyond.cwiseMax(0.0F).norm() - ball_m_;
    if (a_->form == CollisionForm::kBall || gap > margin_m_) return gap;
  }
  gap = std::max(gap, (beyond - box_m_).maxCoeff());
  if (gap > margin_m_) return gap;
  const Vec3 along_a =
      (a_->rotation.transpose() * apart).cwiseAbs() - a_->half_m - axes_.transpose() * half_m;
  gap = std::max(gap, along_a.maxCoeff());
  if (gap > margin_m_ || a_->form == CollisionForm::kBox || a_->nearest == nullptr) return gap;
  // A round solid does not fill the box about it: along its normal at the place that is nearest to the node's middle.
  const NearestPlace place = a_->nearest(*a_->shape, a_->rotation.transpose() * (middle_m - a_->position_m));
  return std::max(gap, place.outside_m - half_m.dot((a_->rotation * place.normal).cwiseAbs()));
}

void MeshWalk::wait(const flatbuffers::Array<std::uint16_t, 3>& lo,
                    const flatbuffers::Array<std::uint16_t, 3>& hi, std::uint32_t child) {
  const Vec3 low(static_cast<float>(lo[0]), static_cast<float>(lo[1]), static_cast<float>(lo[2]));
  const Vec3 high(static_cast<float>(hi[0]), static_cast<float>(hi[1]), static_cast<float>(hi[2]));
  const float half_step_m = 0.5F * mesh_->grid_step_m;
  const float gap = gap_m(half_step_m * (high + low) + mesh_->grid_origin_m, half_step_m * (high - low));
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

bool MeshWalk::step() {
  if (walked_) return triangles_.finish();
  walked_ = triangle_ < end_ ? meet() : visit();
  return false;
}

// The next triangle of a leaf. True: the walk has ended.
bool MeshWalk::meet() {
  triangles_.collide(triangle_++);
  if (triangle_ < end_) return false;
  if (!triangles_.at_bound()) return go_to_next();
  lost_ = waiting_count_ > 0 && !triangles_.passed_over();
  return true;
}

bool MeshWalk::visit() {
  constexpr std::uint32_t kTwoBoxesWork = 4;
  if (a_->work != nullptr) a_->work->charge(kTwoBoxesWork);
  const scene::BvhNode& node = mesh_->nodes[node_];
  wait(*node.lo_a(), *node.hi_a(), (*node.child())[0]);
  if ((*node.child())[1] != (*node.child())[0]) wait(*node.lo_b(), *node.hi_b(), (*node.child())[1]);
  ++visits_;
  return go_to_next();
}

bool MeshWalk::go_to_next() {
  if (waiting_count_ == 0) return true;
  std::pop_heap(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), nearer);
  const std::uint32_t child = waiting_[--waiting_count_].child;
  if (is_leaf(child)) {
    triangle_ = first_triangle(child);
    end_ = triangle_ + triangle_count(child);
    return false;
  }
  node_ = child;
  lost_ = lost_ || visits_ == kMaxMeshNodes;
  return visits_ == kMaxMeshNodes;
}

void MeshCollision::begin(const Convex& a, const MeshView& mesh, float margin_m) {
  found_.count = 0;
  count_ = at_ = 0;
  stage_ = Stage::kSolid;
  walk_.begin(a, mesh, a.centre_m, margin_m, found_);
}

bool MeshCollision::step(const Convex& a, const MeshView& mesh, float margin_m, Work& work, Manifold& out) {
  found_.work = there_.work = point_.work = &work;
  if (stage_ == Stage::kSolid) {
    if (!walk_.step()) return false;
    const TriangleCollision& triangles = walk_.triangles();
    const bool lost = walk_.lost() || triangles.lost();
    drop_far_sides(a.centre_m, found_);
    if (lost) ++out.left_out;
    if ((!triangles.met_all() || lost) && a.form != CollisionForm::kBall) choose_directions(a, lost);
  } else {
    if (!walk_.step()) return false;
    if (stage_ == Stage::kCorners) {
      end_corner(out);
    } else {
      end_split();
    }
  }
  return !begin_next(a, mesh, margin_m, out);
}

// The deepest contact of each direction, at most three: for each of them the corners of the solid's lowest face.
void MeshCollision::choose_directions(const Convex& a, bool lost) {
  for (std::size_t i = 0; i < found_.count; ++i) {
    const ContactPoint& each = found_.points[i];
    std::size_t same = 0;
    constexpr float kSame = 0.99F;
    while (same < count_ && deepest_[same].normal.dot(each.normal) < kSame) ++same;
    if (same == deepest_.size() || (same < count_ && deepest_[same].depth_m >= each.depth_m)) continue;
    deepest_[same] = each;
    count_ = std::max(count_, same + 1);
  }
  // Where no triangle that was met holds the solid off the mesh, one that was left out may.
  constexpr float kReach_m = 1.0e-3F;
  constexpr float kOff = 0.7F;
  const Vec3& normals = walk_.triangles().normals();
  if (const float length = normals.norm(); lost && length > 0.0F) {
    const ContactPoint off{a.centre_m, normals / length, kReach_m};
    bool held = false;
    for (std::size_t i = 0; i < count_; ++i) held = held || deepest_[i].normal.dot(off.normal) > kOff;
    if (!held) deepest_[count_ == deepest_.size() ? count_ - 1 : count_++] = off;
  }
}

// The next place of an outline to meet the mesh. False: there is none, and all that the solid touches is in `out`.
bool MeshCollision::begin_next(const Convex& a, const MeshView& mesh, float margin_m, Manifold& out) {
  for (;;) {
    switch (stage_) {
      case Stage::kSolid:
      case Stage::kNextDirection:
        if (at_ == count_) {
          // After the corners, which are the same ones in each tick.
          for (std::size_t i = 0; i < found_.count; ++i) out.add_distinct(found_.points[i]);
          return false;
        }
        a.outline(-deepest_[at_].normal, std::max(deepest_[at_].depth_m, 0.0F) + margin_m, face_);
        corners_ = std::min(face_.count, held_.size());
        corner_ = 0;
        stage_ = Stage::kCorners;
        break;
      case Stage::kCorners:
        if (corner_ < corners_) return begin_point(a, mesh, margin_m, face_.corner[corner_]);
        corner_ = 0;
        stage_ = Stage::kNextEdge;
        break;
      case Stage::kNextEdge:
        if (corner_ == corners_) {
          ++at_;
          stage_ = Stage::kNextDirection;
        } else if (const std::size_t next = corner_ + 1 == corners_ ? 0 : corner_ + 1;
                   held_[corner_] == held_[next]) {
          ++corner_;
        } else {
          on_m_ = face_.corner[held_[corner_] ? corner_ : next];
          off_m_ = face_.corner[held_[corner_] ? next : corner_];
          splits_ = 0;
          any_ = false;
          stage_ = Stage::kSplits;
        }
        break;
      case Stage::kSplits:
        if (splits_ < kMaxSplits) return begin_point(a, mesh, margin_m, 0.5F * (on_m_ + off_m_));
        if (any_) out.add_distinct(last_);
        ++corner_;
        stage_ = Stage::kNextEdge;
        break;
    }
  }
}

// How deep a point of an outline is below the mesh.
bool MeshCollision::begin_point(const Convex& a, const MeshView& mesh, float margin_m, const Vec3& p) {
  // The deepest place may be on a curved face or on a bump that no corner of the face reaches.
  constexpr float kRoom_m = 1.0e-4F;
  const ContactPoint& deepest = deepest_[at_];
  const Vec3 on_surface = p - a.radius_m * deepest.normal;
  point_ = convex_point(on_surface, std::max(deepest.depth_m + kRoom_m, 0.0F));
  point_.work = a.work;
  there_.count = 0;
  constexpr float kFree_m = 1.0F;
  walk_.begin(point_, mesh, on_surface + kFree_m * deepest.normal, margin_m, there_);
  return true;
}

// False when it is apart from it by more than the margin.
bool MeshCollision::end_point(ContactPoint& out) const {
  const Vec3& normal = deepest_[at_].normal;
  const ContactPoint* best = nullptr;
  for (std::size_t i = 0; i < there_.count; ++i) {
    constexpr float kAlike = 0.5F;
    const ContactPoint& each = there_.points[i];
    if (each.normal.dot(normal) > kAlike && (best == nullptr || each.depth_m > best->depth_m)) best = &each;
  }
  if (best == nullptr) return false;
  out = *best;
  return true;
}

void MeshCollision::end_corner(Manifold& out) {
  ContactPoint point;
  held_[corner_] = end_point(point);
  if (held_[corner_]) out.add_distinct(point);
  ++corner_;
}

// Where an edge leaves the mesh.
void MeshCollision::end_split() {
  const Vec3 middle = 0.5F * (on_m_ + off_m_);
  if (end_point(last_)) {
    on_m_ = middle;
    any_ = true;
  } else {
    off_m_ = middle;
  }
  ++splits_;
}

}  // namespace thimble::control
