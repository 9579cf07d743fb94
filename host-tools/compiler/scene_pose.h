// A pose as the scene file gives it, for objects and for what is placed inside one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host-tools/compiler/scene_value.h"

namespace thimble::host {

// The object is first rotated about its origin, then moved. Keys that are missing: at the origin, not rotated.
void read_pose(const Value& value, Eigen::Vector3d& position_m, Eigen::Quaterniond& rotation);

}  // namespace thimble::host
