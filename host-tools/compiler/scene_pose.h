// A pose as the scene file gives it, for objects and for what is placed inside one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string_view>

#include "host-tools/compiler/scene_value.h"

namespace thimble::host {

inline constexpr std::array<std::string_view, 2> kPoseKeys{"position_m", "rotation_deg"};

// First turned, then moved. Keys that are not given leave their part as it is.
void read_pose(const Value& value, Eigen::Vector3d& position_m, Eigen::Quaterniond& rotation);

}  // namespace thimble::host
