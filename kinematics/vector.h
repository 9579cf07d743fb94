// The algebra of the tick: three-vectors and 3x3 matrices of float, from Eigen, fixed in size, never on the
// heap.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace thimble {

using Vec3 = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3f;

// Of the vector (x, y). libm's hypot differs in the last bit from one target to the next; a root does not.
[[nodiscard]] inline float planar_length(float x, float y) noexcept { return std::sqrt(x * x + y * y); }

}  // namespace thimble
