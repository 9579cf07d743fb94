// Triangles near a place: the walk of the tree, and the nearest point. For the files of the mesh only.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh_view.h"
#include "control/work.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr int kMaxSeparationNodes = 512;

// The point of the triangle (a, a + ab, a + ac) nearest to a + ap, as a vector from a (Ericson 2005, 5.1.5).
inline Vec3 nearest_on_triangle(const Vec3& ab, const Vec3& ac, const Vec3& ap) {
  const float d1 = ab.dot(ap);
  const float d2 = ac.dot(ap);
  if (d1 <= 0.0F && d2 <= 0.0F) return Vec3::Zero();
  const float bb = ab.squaredNorm();
  const float cc = ac.squaredNorm();
  const float bc = ab.dot(ac);
  const float d3 = d1 - bb;
  const float d4 = d2 - bc;
  if (d3 >= 0.0F && d4 <= d3) return ab;
  const float d5 = d1 - bc;
  const float d6 = d2 - cc;
  if (d6 >= 0.0F && d5 <= d6) return ac;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) return (d1 / (d1 - d3)) * ab;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) return (d2 / (d2 - d6)) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0F && d4 - d3 >= 0.0F && d5 - d6 >= 0.0F)
    return ab + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (ac - ab);
  // From the plane: the weights vb and vc of a triangle of 40 x 0.4 mm place it up to 16 um aside.
  const Vec3 area = ab.cross(ac);
  return ap - (area.dot(ap) / area.squaredNorm()) * area;
}

// A ball in steps of the mesh's grid, and the box about it.
struct GridBall {
  std::array<std::uint32_t, 3> lo, hi;
  Vec3 middle;
  float radius2;

  // False when the mesh's grid is elsewhere.
  bool about(const MeshView& mesh, const Vec3& middle_m, float radius_m) {
    middle = (middle_m - mesh.grid_origin_m) * mesh.grid_scale;
    const float radius = radius_m * mesh.grid_scale + 2.0F;
    radius2 = radius * radius;
    constexpr float kGridEnd = 65535.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const float from = middle[axis] - radius;
      const float to = middle[axis] + radius;
      if (!(to >= 0.0F && from <= kGridEnd)) return false;
      lo[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(from, 0.0F, kGridEnd));
      hi[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(std::clamp(to, 0.0F, kGridEnd));
    }
    return true;
  }
  [[nodiscard]] bool meets(const GridPoint& low, const GridPoint& high) const {
    for (std::uint16_t axis = 0; axis < 3; ++axis) {
      if (low[axis] > hi[axis] || high[axis] < lo[axis]) return false;
    }
    return true;
  }
  // Of a ball that can be larger than many boxes: the ball itself.
  [[nodiscard]] bool is_near(const GridPoint& low, const GridPoint& high) const {
    const Vec3 least(low[0], low[1], low[2]);
    const Vec3 most(high[0], high[1], high[2]);
    return (middle - middle.cwiseMax(least).cwiseMin(most)).squaredNorm() <= radius2;
  }
};

// Visits all leaves whose boxes meets(lo, hi) allows as visit(leaf, lo, hi), at most kMaxSeparationNodes nodes of the tree. False
// when these are too few, when the work is spent, or when a visit returns false.
template <typename Meets, typename Visit>
[[nodiscard]] bool for_each_leaf(const MeshView& mesh, Work& work, const Meets& meets, const Visit& visit) {
  std::array<std::uint32_t, kMaxBvhDepth + 1> stack;
  std::size_t depth = 0;
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxSeparationNodes && work.spend(kNodeWork); ++visits) {
    const scene::BvhNode& node = mesh.nodes[at];
    std::array<std::uint32_t, 2> inner;
    std::size_t inner_count = 0;
    for (std::uint16_t c = 0; c < 2; ++c) {
      const GridPoint& lo = c == 0 ? *node.lo_a() : *node.lo_b();
      const GridPoint& hi = c == 0 ? *node.hi_a() : *node.hi_b();
      if (!meets(lo, hi)) continue;
      const std::uint32_t child = (*node.child())[c];
      if (!is_leaf(child)) {
        inner[inner_count++] = child;
        continue;
      }
      if (!visit(child, lo, hi)) return false;
    }
    if (inner_count == 0) {
      if (depth == 0) return true;
      at = stack[--depth];
    } else {
      at = inner[0];
      if (inner_count == 2) {
        if (depth == stack.size()) return false;
        stack[depth++] = inner[1];
      }
    }
  }
  return false;
}

// The same for the triangles of these leaves. triangle_work: what a visit costs.
template <typename Meets, typename Visit>
[[nodiscard]] bool for_each_near(const MeshView& mesh, Work& work, const Meets& meets, const Visit& visit,
                                 std::uint32_t triangle_work = kNearTriangleWork) {
  return for_each_leaf(mesh, work, meets,
                       [&](std::uint32_t leaf, const GridPoint& /*lo*/, const GridPoint& /*hi*/) {
                         const std::uint32_t first = first_triangle(leaf);
                         if (!work.spend(triangle_work * triangle_count(leaf))) return false;
                         for (std::uint32_t i = first; i < first + triangle_count(leaf); ++i)
                           if (!visit(i)) return false;
                         return true;
                       });
}

}  // namespace thimble::control
