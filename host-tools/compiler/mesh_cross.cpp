#include "host-tools/compiler/mesh_cross.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Points = std::span<const Vector3d>;

// True when the two point sets lie more than `tolerance` apart along `axis`. An axis without length separates
// nothing.
bool apart(const Vector3d& axis, Points a, Points b, double tolerance) {
  const double length = axis.norm();
  double lo_a = 0.0;
  double hi_a = 0.0;
  for (const Vector3d& p : a.subspan(1)) {
    const double x = axis.dot(p - a[0]);
    lo_a = std::min(lo_a, x);
    hi_a = std::max(hi_a, x);
  }
  double lo_b = axis.dot(b[0] - a[0]);
  double hi_b = lo_b;
  for (const Vector3d& p : b.subspan(1)) {
    const double x = axis.dot(p - a[0]);
    lo_b = std::min(lo_b, x);
    hi_b = std::max(hi_b, x);
  }
  return std::max(lo_b - hi_a, lo_a - hi_b) > tolerance * length;
}

Vector3d edge(Points points, std::size_t i) { return points[(i + 1) % points.size()] - points[i]; }

std::size_t edge_count(Points points) { return points.size() == 2 ? 1 : 3; }

// Separating axes for a triangle and a triangle or segment: the faces' normals, the edges' cross products
// and, for the flat case, the edges' normals within each face. A separation found is a true lower bound of
// the distance.
bool separated(Points a, Points b, double tolerance) {
  const Vector3d normal_a = edge(a, 0).cross(edge(a, 1));
  if (apart(normal_a, a, b, tolerance)) {
    return true;
  }
  const bool b_is_triangle = b.size() == 3;
  const Vector3d normal_b =
      b_is_triangle ? edge(b, 0).cross(edge(b, 1)).eval() : edge(b, 0).cross(normal_a).eval();
  if (apart(normal_b, a, b, tolerance)) {
    return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (apart(normal_a.cross(edge(a, i)), a, b, tolerance)) {
      return true;
    }
    for (std::size_t j = 0; j < edge_count(b); ++j) {
      if (apart(edge(a, i).cross(edge(b, j)), a, b, tolerance)) {
        return true;
      }
    }
  }
  for (std::size_t j = 0; b_is_triangle && j < 3; ++j) {
    if (apart(normal_b.cross(edge(b, j)), a, b, tolerance)) {
      return true;
    }
  }
  return false;
}

double distance_to_plane(const Vector3d& p, Points triangle) {
  return std::abs(edge(triangle, 0).cross(edge(triangle, 1)).normalized().dot(p - triangle[0]));
}

}  // namespace

bool triangles_cross(const TriangleCorners& a, const TriangleCorners& b, double tolerance_m) {
  std::size_t shared = 0;
  std::array<bool, 3> a_shared{};
  std::array<bool, 3> b_shared{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (a.index[i] == b.index[j]) {
        a_shared[i] = true;
        b_shared[j] = true;
        ++shared;
      }
    }
  }
  const auto others = [](const TriangleCorners& triangle, const std::array<bool, 3>& skip) {
    std::array<Vector3d, 3> points;
    std::size_t size = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!skip[i]) {
        points[size++] = triangle.at_m[i];
      }
    }
    return points;
  };
  if (shared == 0) {
    return !separated(a.at_m, b.at_m, tolerance_m);
  }
  const std::array<Vector3d, 3> far_a = others(a, a_shared);
  const std::array<Vector3d, 3> far_b = others(b, b_shared);
  if (shared == 1) {
    // Whatever they have in common runs from the shared corner to the far edge of one of them.
    return !separated(a.at_m, Points(far_b).first(2), tolerance_m) ||
           !separated(b.at_m, Points(far_a).first(2), tolerance_m);
  }
  if (shared == 2) {
    // Folded onto each other: both on the same side of the shared edge, in one plane.
    const std::size_t first = a_shared[0] ? 0 : 1;
    const std::size_t second = a_shared[2] ? 2 : 1;
    const Vector3d along = (a.at_m[second] - a.at_m[first]).normalized();
    const Vector3d to_a = far_a[0] - a.at_m[first];
    const Vector3d to_b = far_b[0] - a.at_m[first];
    const bool same_side = (to_a - along * along.dot(to_a)).dot(to_b - along * along.dot(to_b)) > 0.0;
    return same_side &&
           std::min(distance_to_plane(far_a[0], b.at_m), distance_to_plane(far_b[0], a.at_m)) <= tolerance_m;
  }
  return true;
}

}  // namespace thimble::host
