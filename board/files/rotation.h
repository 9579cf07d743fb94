// The rotation that a key rotation_deg of a JSON file stands for.
#pragma once

#include <Eigen/Core>

namespace thimble::board {

// Roll, pitch and yaw in degrees: about x, then y, then z, which stay where they are. A vector of the turned frame times it is one of the frame
// outside. Quarter turns are exact: an arm that stands upright is level to the last bit.
[[nodiscard]] Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rpy_deg);

}  // namespace thimble::board
