// Two convex solids of any kind. The normal is the direction of least overlap. It is found by descent: a is moved along
// the best direction so far until both are kApart_m apart; the nearest points then give a better direction. So only
// solids that are apart are measured, and the depth is exact for the direction. The contact points are those of the two
// faces or edges that are farthest along the normal, one clipped to the other.
#include <algorithm>
#include <cmath>
#include <limits>

#include "control/bodies/convex.h"

namespace thimble::control {
namespace {

// Far above the rounding of a place (1e-7 m at 1 m), so that the direction between nearest points is known to 1e-3.
constexpr float kApart_m = 5.0e-4F;
constexpr int kMaxDescents = 6;
// A direction is better when it saves this much: the normals of flat faces stay exactly as they are.
constexpr float kBetter_m = 2.0e-7F;
constexpr float kDeep_m = 3.0e-4F;

void add_single(const Overlap& overlap, float radius_of_a_m, Manifold& out) {
  out.add_distinct({overlap.of_core_m + (0.5F * overlap.depth_m - radius_of_a_m) * overlap.normal,
                    overlap.normal, overlap.depth_m});
}

struct Surfaces {
  const Outline& a;  // of the cores
  const Outline& b;
  float radii_m;  // of both roundings together
  float radius_of_a_m;
};

// A point of one core and the distance along the normal to the other core: the contact point between the surfaces.
void add_between(const Surfaces& of, const Overlap& overlap, const Vec3& p, bool of_a, float core_depth_m,
                 float margin_m, Manifold& out) {
  const float depth = std::min(core_depth_m + of.radii_m, overlap.depth_m);
  if (depth < -margin_m) return;
  const Vec3 on_a = of_a ? p : Vec3(p - core_depth_m * overlap.normal);
  out.add_distinct({on_a + (0.5F * depth - of.radius_of_a_m) * overlap.normal, overlap.normal, depth});
}

// The normal of a face with the length of twice its area.
Vec3 area_of(const Outline& face) {
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 2; i < face.count; ++i)
    area += (face.corner[i - 1] - face.corner[0]).cross(face.corner[i] - face.corner[0]);
  return area;
}

// The other outline, clipped to the sides of a face. False when nothing is left of it.
bool add_over_face(const Surfaces& of, const Overlap& overlap, bool face_of_b, float margin_m,
                   Manifold& out) {
  const Outline& face = face_of_b ? of.b : of.a;
  Outline over = face_of_b ? of.a : of.b;
  const Vec3& normal = overlap.normal;
  const Vec3 area = area_of(face);
  const float along = area.dot(normal);
  constexpr float kSteep = 0.2F;
  if (along * along <= kSteep * kSteep * area.squaredNorm()) return false;
  for (std::size_t i = 0; i < face.count && over.count > 0; ++i) {
    const Vec3& p = face.corner[i];
    const Vec3 edge = face.corner[i + 1 == face.count ? 0 : i + 1] - p;
    Vec3 outwards = edge.cross(normal);
    if (along < 0.0F) outwards = -outwards;
    over = clip(over, outwards, outwards.dot(p));
  }
  const std::size_t before = out.count;
  for (std::size_t i = 0; i < over.count; ++i) {
    const float to_face = area.dot(face.corner[0] - over.corner[i]) / along;
    add_between(of, overlap, over.corner[i], face_of_b, face_of_b ? to_face : -to_face, margin_m, out);
  }
  return out.count > before;
}

// Two lines side by side. False when they cross or pass each other.
bool add_along_lines(const Surfaces& of, const Overlap& overlap, float margin_m, Manifold& out) {
  const Vec3 along_a = of.a.corner[1] - of.a.corner[0];
  const Vec3 along_b = of.b.corner[1] - of.b.corner[0];
  const float length2 = along_b.squaredNorm();
  constexpr float kParallel_rad = 0.05F;
  const float crossed2 = along_a.cross(along_b).squaredNorm();
  if (!(crossed2 < kParallel_rad * kParallel_rad * along_a.squaredNorm() * length2)) return false;
  const float from = along_b.dot(of.a.corner[0] - of.b.corner[0]) / length2;
  const float step = along_b.dot(along_a) / length2;
  const float first = -from / step;
  const float last = (1.0F - from) / step;
  const float lo = std::max(0.0F, std::min(first, last));
  const float hi = std::min(1.0F, std::max(first, last));
  if (lo > hi) return false;
  for (const float part : {lo, hi}) {
    const Vec3 on_a = of.a.corner[0] + part * along_a;
    const Vec3 on_b = of.b.corner[0] + (from + part * step) * along_b;
    add_between(of, overlap, on_a, true, overlap.normal.dot(on_b - on_a), margin_m, out);
  }
  return true;
}

}  // namespace

float depth_along(const Convex& a, const Convex& b, const Vec3& normal) noexcept {
  return normal.dot(b.farthest(normal).at_m - a.farthest(-normal).at_m) + a.radius_m + b.radius_m;
}

void OverlapSearch::begin(const Overlap& first) noexcept {
  overlap_ = first;
  overlap_.settled = false;
  descents_ = 0;
  descends_ = false;
}

void OverlapSearch::begin_descent(const Convex& a, const Convex& b) noexcept {
  const float shift_m = std::max(0.0F, overlap_.depth_m - (a.radius_m + b.radius_m) + kApart_m);
  shift_m_ = shift_m * overlap_.normal;
  raised_ = shift_m > 0.0F;
  distance_.begin(overlap_.normal);
  descends_ = true;
}

bool OverlapSearch::step(const Convex& a, const Convex& b, float margin_m) noexcept {
  if (!descends_) begin_descent(a, b);
  if (!distance_.step(a, b, shift_m_, margin_m)) return false;
  descends_ = false;
  found_ = false;
  if (distance_.distance() == Distance::kApart) return true;
  if (distance_.distance() ==
      Distance::kTouching) {  // by rounding: the direction so far, at the deepest place of a
    overlap_.of_core_m = a.farthest(-overlap_.normal).at_m;
    found_ = true;
    return true;
  }
  const NearestPair pair = distance_.pair();
  const Vec3 normal = pair.apart_m.normalized();
  const float depth_m = depth_along(a, b, normal);
  if (depth_m < -margin_m) {
    overlap_.normal = normal;
    return true;
  }
  found_ = true;
  overlap_.of_core_m = pair.of_a_m - shift_m_;
  overlap_.settled = !raised_ || depth_m > overlap_.depth_m - kBetter_m;
  if (depth_m > overlap_.depth_m - kBetter_m) return true;
  overlap_.normal = normal;
  overlap_.depth_m = depth_m;
  return overlap_.settled || ++descents_ == kMaxDescents;
}

void add_contacts(const Convex& a, const Convex& b, const Overlap& overlap, float margin_m,
                  Manifold& out) noexcept {
  constexpr float kRounding_m = 1.0e-6F;
  const float depth_m = std::max(0.0F, overlap.depth_m) + margin_m + kRounding_m;
  Outline of_a;
  Outline of_b;
  a.outline(-overlap.normal, depth_m, of_a);
  b.outline(overlap.normal, depth_m, of_b);
  const Surfaces of{of_a, of_b, a.radius_m + b.radius_m, a.radius_m};
  const std::size_t before = out.count;
  bool added = false;
  if (of_a.count == 2 && of_b.count == 2) {
    added = add_along_lines(of, overlap, margin_m, out);
  } else if (of_a.count >= 2 && of_b.count >= 2) {
    added = add_over_face(of, overlap, of_b.count >= 3, margin_m, out);
  }
  // On a curved face or between two edges the deepest place is no corner of the outlines.
  constexpr float kAsDeep_m = 2.0e-6F;
  for (std::size_t i = before; i < out.count && added; ++i)
    if (out.points[i].depth_m > overlap.depth_m - kAsDeep_m) return;
  add_single(overlap, a.radius_m, out);
}

void ConvexCollision::begin() noexcept {
  axis_ = 0;
  restarts_ = -1;
  best_ = {};
  best_.depth_m = std::numeric_limits<float>::infinity();
}

bool ConvexCollision::may_touch(const Convex& a, const Convex& b, const Vec3& axis, float margin_m) noexcept {
  if (a.work != nullptr) a.work->charge(1);
  const Vec3 normal = axis.dot(a.centre_m - b.centre_m) < 0.0F ? Vec3(-axis) : axis;
  const float depth_m = depth_along(a, b, normal);
  if (depth_m < best_.depth_m - kBetter_m) {
    best_.depth_m = depth_m;
    best_.normal = normal;
  }
  return depth_m >= -margin_m;
}

// First the axes of the boxes about them; then the way from b to a; then what lies across both.
bool ConvexCollision::step(const Convex& a, const Convex& b, float margin_m, Manifold& out) noexcept {
  constexpr int kBoxAxes = 6;
  constexpr int kCrosses = 9;
  if (restarts_ >= 0) return descend(a, b, margin_m, out);
  const int axis = axis_++;
  if (axis < kBoxAxes) {
    const Convex& each = axis < 3 ? b : a;
    return each.form != CollisionForm::kBall && !may_touch(a, b, each.rotation.col(axis % 3), margin_m);
  }
  if (axis == kBoxAxes) {
    const Vec3 from_b = a.centre_m - b.centre_m;
    return from_b.squaredNorm() > 0.0F && !may_touch(a, b, from_b.normalized(), margin_m);
  }
  // Bodies that hold each other overlap by less. Then no face of the boxes about them is near: two edges may be.
  if (const int i = axis - kBoxAxes - 1; i < kCrosses && best_.depth_m > kDeep_m) {
    const Vec3 cross = a.rotation.col(i / 3).cross(b.rotation.col(i % 3));
    constexpr float kLeastSine = 0.05F;
    return cross.squaredNorm() > kLeastSine * kLeastSine && !may_touch(a, b, cross.normalized(), margin_m);
  }
  if (!std::isfinite(best_.depth_m)) return true;
  restarts_ = 0;
  search_.begin(best_);
  return false;
}

// A descent can end at a direction that is the best of its neighbours only. Begin again from between it and others.
bool ConvexCollision::descend(const Convex& a, const Convex& b, float margin_m, Manifold& out) noexcept {
  if (!search_.step(a, b, margin_m)) return false;
  if (!search_.found()) return true;
  const Overlap& found = search_.overlap();
  if (restarts_ == 0 || found.depth_m < best_.depth_m - kBetter_m) best_ = found;
  constexpr int kMaxRestarts = 6;
  if (restarts_ == kMaxRestarts || best_.depth_m <= kDeep_m) {
    add_contacts(a, b, best_, margin_m, out);
    return true;
  }
  const Vec3 axis = restarts_ < 3 ? a.rotation.col(restarts_) : b.rotation.col(restarts_ - 3);
  ++restarts_;
  const Vec3 aside = axis.dot(a.centre_m - b.centre_m) < 0.0F ? Vec3(-axis) : axis;
  Overlap other;
  other.normal = (best_.normal + aside).normalized();
  other.depth_m = depth_along(a, b, other.normal);
  search_.begin(other);
  return false;
}

}  // namespace thimble::control
