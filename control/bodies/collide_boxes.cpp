#include <algorithm>
#include <cmath>
#include <limits>

#include "control/bodies/collide.h"
#include "control/bodies/outline.h"

namespace thimble::control {
namespace {

// The incident face of `other` (the one most opposed to `normal`), clipped to the sides of the face of `box`
// on axis k.
void clip_faces(const OrientedBox& box, Eigen::Index k, const Vec3& normal, const OrientedBox& other,
                bool reversed, float margin, Manifold& out) {
  const Vec3 along = other.axes.transpose() * normal;
  Eigen::Index face = 0;
  along.cwiseAbs().maxCoeff(&face);
  const Vec3 out_of_face = along[face] > 0.0F ? Vec3(-other.axes.col(face)) : Vec3(other.axes.col(face));
  const Eigen::Index u = (face + 1) % 3;
  const Eigen::Index v = (face + 2) % 3;
  const Vec3 middle = other.centre_m + other.half_m[face] * out_of_face;
  const Vec3 side_u = other.half_m[u] * other.axes.col(u);
  const Vec3 side_v = other.half_m[v] * other.axes.col(v);
  Outline polygon;
  polygon.add(middle + side_u + side_v);
  polygon.add(middle - side_u + side_v);
  polygon.add(middle - side_u - side_v);
  polygon.add(middle + side_u - side_v);
  for (const Eigen::Index side : {(k + 1) % 3, (k + 2) % 3}) {
    const Vec3 axis = box.axes.col(side);
    const float at = axis.dot(box.centre_m);
    polygon = clip(polygon, axis, at + box.half_m[side]);
    polygon = clip(polygon, -axis, box.half_m[side] - at);
  }
  const float offset = normal.dot(box.centre_m) + box.half_m[k];
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const float depth = offset - normal.dot(polygon.corner[i]);
    if (depth < -margin) continue;
    out.add({polygon.corner[i] + 0.5F * depth * normal, reversed ? Vec3(-normal) : normal, depth});
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
  const auto extent = [](const OrientedBox& box, const Vec3& direction) {
    return box.half_m.dot((box.axes.transpose() * direction).cwiseAbs());
  };
  const auto gap = [&](const Vec3& direction) {
    return std::abs(from_b.dot(direction)) - extent(a, direction) - extent(b, direction);
  };

  // The face with the least penetration; a pair of edges only where its penetration is clearly less, so that
  // a resting face contact does not change to an edge contact.
  float face_gap = -std::numeric_limits<float>::infinity();
  Eigen::Index face = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const Vec3 direction = i < 3 ? a.axes.col(i) : b.axes.col(i - 3);
    const float g = gap(direction);
    if (g > margin_m) return;
    constexpr float kSooner_m = 1.0e-6F;  // of equal faces the first, independent of rounding
    if (g > face_gap + kSooner_m) {
      face_gap = g;
      face = i;
    }
  }
  float edge_gap = -std::numeric_limits<float>::infinity();
  Eigen::Index edge_a = 0;
  Eigen::Index edge_b = 0;
  Vec3 edge_direction = Vec3::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      const Vec3 cross = a.axes.col(i).cross(b.axes.col(j));
      const float length = cross.norm();
      constexpr float kLeastSine = 1.0e-2F;
      if (length < kLeastSine) continue;
      const Vec3 direction = cross / length;
      const float g = gap(direction);
      if (g > margin_m) return;
      if (g > edge_gap) {
        edge_gap = g;
        edge_a = i;
        edge_b = j;
        edge_direction = direction;
      }
    }
  }
  constexpr float kShare = 0.9F;
  constexpr float kClearly_m = 1.0e-5F;
  const bool edges = edge_gap > std::max(kShare * face_gap, face_gap) + kClearly_m;
  if (edges) {
    const Vec3 normal = edge_direction.dot(from_b) < 0.0F ? Vec3(-edge_direction) : edge_direction;
    const Vec3 p = edge_middle(a, edge_a, -normal);
    const Vec3 q = edge_middle(b, edge_b, normal);
    const Vec3 da = a.axes.col(edge_a);
    const Vec3 db = b.axes.col(edge_b);
    // Nearest points of two lines of unit direction.
    const float along = da.dot(db);
    const float scale = 1.0F / (1.0F - along * along);
    const Vec3 r = q - p;
    const float s = std::clamp((r.dot(da) - along * r.dot(db)) * scale, -a.half_m[edge_a], a.half_m[edge_a]);
    const float t = std::clamp((along * r.dot(da) - r.dot(db)) * scale, -b.half_m[edge_b], b.half_m[edge_b]);
    out.add({0.5F * (p + s * da + q + t * db), normal, -edge_gap});
    return;
  }
  if (face < 3) {
    const Vec3 axis = a.axes.col(face);
    const Vec3 out_of_a = axis.dot(from_b) > 0.0F ? Vec3(-axis) : axis;
    clip_faces(a, face, out_of_a, b, true, margin_m, out);
  } else {
    const Vec3 axis = b.axes.col(face - 3);
    const Vec3 out_of_b = axis.dot(from_b) < 0.0F ? Vec3(-axis) : axis;
    clip_faces(b, face - 3, out_of_b, a, false, margin_m, out);
  }
}

}  // namespace thimble::control
