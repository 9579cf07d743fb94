// Tests whether two triangles of a mesh cross. Conservative: closer than `tolerance` counts as crossing, shared corners
// do not. Called by compile_mesh for TriangleFlag::Pierced.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace thimble::host {

struct TriangleCorners {
  std::array<std::uint32_t, 3> index;  // equal indices are the same corner
  std::array<Eigen::Vector3d, 3> at_m;
};

// Both triangles have an area. True when they meet anywhere but at the corners or the edge that they share.
[[nodiscard]] bool triangles_cross(const TriangleCorners& a, const TriangleCorners& b, double tolerance_m);

}  // namespace thimble::host
