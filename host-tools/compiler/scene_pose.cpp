#include "host-tools/compiler/scene_pose.h"

#include <numbers>

namespace thimble::host {

void read_pose(const Value& value, Eigen::Vector3d& position_m, Eigen::Quaterniond& rotation) {
  const ScenePart part(value, "pose");
  position_m = part.vector("position_m");
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Vector3d angles = part.vector("rotation_deg") * (std::numbers::pi / 180.0);
  rotation = AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
             AngleAxisd(angles.x(), Vector3d::UnitX());
  rotation.normalize();
}

}  // namespace thimble::host
