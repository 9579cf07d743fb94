// The algebra of the tick: three-vectors and 3x3 matrices of float, from Eigen, fixed in size, never on the
// heap.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace thimble {

using Vec3 = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3f;

}  // namespace thimble
