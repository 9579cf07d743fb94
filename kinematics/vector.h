// Vector and matrix types of the tick: Eigen, float, fixed size, no heap.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace thimble {

using Vec3 = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3f;

// Length of the vector (x, y). Not hypot(): libm's differs in the last bit between targets, a square root
// does not.
[[nodiscard]] inline float planar_length(float x, float y) noexcept { return std::sqrt(x * x + y * y); }

}  // namespace thimble
