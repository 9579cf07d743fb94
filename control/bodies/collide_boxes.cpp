#include <algorithm>
#include <cmath>
#include <limits>

#include "control/bodies/collide.h"
#include "control/bodies/outline.h"

namespace thimble::control {
namespace {

// The part of the polygon where sign * its coordinate on the axis is at most limit.
void clip_along(Outline& polygon, Eigen::Index axis, float sign, float limit) {
  bool beyond = false;
  for (std::size_t i = 0; i < polygon.count; ++i) beyond = beyond || sign * polygon.corner[i][axis] > limit;
  if (beyond) polygon = clip(polygon, sign * Vec3::Unit(axis), limit);
}

// The incident face of `other` (the one most opposed to `normal`), clipped to the sides of the face of `box`
// on axis k, in the frame of the box. `axes`, `centre_m`: of the other one in that frame. sign: of the normal on axis k.
void clip_faces(const OrientedBox& box, Eigen::Index k, float sign, const Mat3& axes, const Vec3& centre_m,
                const Vec3& half_m, bool reversed, float margin, Manifold& out) {
  Eigen::Index face = 0;
  axes.row(k).cwiseAbs().maxCoeff(&face);
  const float towards = sign * axes(k, face) > 0.0F ? -half_m[face] : half_m[face];
  const Eigen::Index u = (face + 1) % 3;
  const Eigen::Index v = (face + 2) % 3;
  const Vec3 middle = centre_m + towards * axes.col(face);
  const Vec3 side_u = half_m[u] * axes.col(u);
  const Vec3 side_v = half_m[v] * axes.col(v);
  Outline polygon;
  polygon.add(middle + side_u + side_v);
  polygon.add(middle - side_u + side_v);
  polygon.add(middle - side_u - side_v);
  polygon.add(middle + side_u - side_v);
  for (const Eigen::Index side : {(k + 1) % 3, (k + 2) % 3}) {
    clip_along(polygon, side, 1.0F, box.half_m[side]);
    clip_along(polygon, side, -1.0F, box.half_m[side]);
  }
  const Vec3 normal = sign * box.axes.col(k);
  for (std::size_t i = 0; i < polygon.count; ++i) {
    Vec3& corner = polygon.corner[i];
    const float depth = box.half_m[k] - sign * corner[k];
    if (depth < -margin) continue;
    corner[k] += 0.5F * depth * sign;
    out.add({box.centre_m + box.axes * corner, reversed ? Vec3(-normal) : normal, depth});
  }
}

// The middle of the edge of a box that is farthest along `direction`.
Vec3 edge_middle(const OrientedBox& box, Eigen::Index along, const Vec3& direction) {
  Vec3 p = box.centre_m;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (i == along) continue;
    const Vec3 axis = box.axes.col(i);
    p += std::copysign(box.half_m[i], axis.dot(direction)) * axis;
  }
  return p;
}

}  // namespace

void collide_boxes(const OrientedBox& a, const OrientedBox& b, float margin_m, Manifold& out) noexcept {
  const Vec3 from_b = a.centre_m - b.centre_m;
  // b in the frame of a: its axes, their lengths along those of a, and the place of a.
  const Mat3 axes = a.axes.transpose() * b.axes;
  const Mat3 along = axes.cwiseAbs();
  const Vec3 in_a = a.axes.transpose() * from_b;
  const Vec3 in_b = b.axes.transpose() * from_b;
  const Vec3 faces_of_a = in_a.cwiseAbs() - a.half_m - along * b.half_m;
  const Vec3 faces_of_b = in_b.cwiseAbs() - b.half_m - along.transpose() * a.half_m;

  // The face with the least penetration; a pair of edges only where its penetration is clearly less, so that
  // a resting face contact does not change to an edge contact.
  float face_gap = -std::numeric_limits<float>::infinity();
  Eigen::Index face = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const float g = i < 3 ? faces_of_a[i] : faces_of_b[i - 3];
    if (g > margin_m) return;
    constexpr float kSooner_m = 1.0e-6F;  // of equal faces the first, independent of rounding
    if (g > face_gap + kSooner_m) {
      face_gap = g;
      face = i;
    }
  }
  constexpr float kShare = 0.9F;
  constexpr float kClearly_m = 1.0e-5F;
  float edge_gap = std::max(kShare * face_gap, face_gap) + kClearly_m;
  bool edges = false;
  Eigen::Index edge_a = 0;
  Eigen::Index edge_b = 0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index i1 = (i + 1) % 3;
    const Eigen::Index i2 = (i + 2) % 3;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const Eigen::Index j1 = (j + 1) % 3;
      const Eigen::Index j2 = (j + 2) % 3;
      // Along the cross product of the two axes, which is no longer than 1.
      float g = std::abs(in_a[i2] * axes(i1, j) - in_a[i1] * axes(i2, j)) - a.half_m[i1] * along(i2, j) -
                a.half_m[i2] * along(i1, j) - b.half_m[j1] * along(i, j2) - b.half_m[j2] * along(i, j1);
      if (g <= std::min(edge_gap, 0.0F)) continue;
      const float length = planar_length(axes(i1, j), axes(i2, j));
      constexpr float kLeastSine = 1.0e-2F;
      if (length < kLeastSine) continue;
      g /= length;
      if (g > margin_m) return;
      if (g > edge_gap) {
        edge_gap = g;
        edge_a = i;
        edge_b = j;
        edges = true;
      }
    }
  }
  if (edges) {
    const Vec3 direction = a.axes.col(edge_a).cross(b.axes.col(edge_b)).normalized();
    const Vec3 normal = direction.dot(from_b) < 0.0F ? Vec3(-direction) : direction;
    const Vec3 p = edge_middle(a, edge_a, -normal);
    const Vec3 q = edge_middle(b, edge_b, normal);
    const Vec3 da = a.axes.col(edge_a);
    const Vec3 db = b.axes.col(edge_b);
    // Nearest points of two lines of unit direction.
    const float cosine = da.dot(db);
    const float scale = 1.0F / (1.0F - cosine * cosine);
    const Vec3 r = q - p;
    const float s = std::clamp((r.dot(da) - cosine * r.dot(db)) * scale, -a.half_m[edge_a], a.half_m[edge_a]);
    const float t = std::clamp((cosine * r.dot(da) - r.dot(db)) * scale, -b.half_m[edge_b], b.half_m[edge_b]);
    out.add({0.5F * (p + s * da + q + t * db), normal, -edge_gap});
    return;
  }
  if (face < 3) {
    const float sign = in_a[face] > 0.0F ? -1.0F : 1.0F;
    clip_faces(a, face, sign, axes, -in_a, b.half_m, true, margin_m, out);
  } else {
    const float sign = in_b[face - 3] < 0.0F ? -1.0F : 1.0F;
    clip_faces(b, face - 3, sign, axes.transpose(), in_b, a.half_m, false, margin_m, out);
  }
}

}  // namespace thimble::control
