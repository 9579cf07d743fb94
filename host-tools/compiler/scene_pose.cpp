#include "host-tools/compiler/scene_pose.h"

#include <numbers>

namespace thimble::host {

void read_pose(const Value& value, Eigen::Vector3d& position_m, Eigen::Quaterniond& rotation) {
  value.object("a pose", kPoseKeys);
  if (value.has("position_m")) {
    position_m = value.at("position_m").as_vector(kCoordinate);
  }
  if (value.has("rotation_deg")) {
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    const Vector3d angles =
        value.at("rotation_deg").as_vector({-360.0, 360.0, false, "degrees"}) * (std::numbers::pi / 180.0);
    rotation = AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
               AngleAxisd(angles.x(), Vector3d::UnitX());
    rotation.normalize();
  }
}

}  // namespace thimble::host
