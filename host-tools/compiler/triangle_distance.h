// The distance between two triangles. The compiler shows with it where a tip with a size touches nothing.
#pragma once

#include <Eigen/Core>
#include <array>

namespace thimble::host {

using Triangle3 = std::array<Eigen::Vector3d, 3>;

// Zero where they meet. Triangles without area are segments or points. Source: Ericson, Real-Time Collision Detection (2005), 5.1.5,
// 5.1.9, 5.3.6.
[[nodiscard]] double triangle_distance(const Triangle3& a, const Triangle3& b);
[[nodiscard]] double point_distance(const Eigen::Vector3d& p, const Triangle3& triangle);

}  // namespace thimble::host
