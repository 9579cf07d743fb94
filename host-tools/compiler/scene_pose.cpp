#include "host-tools/compiler/scene_pose.h"

#include <numbers>

#include "host-tools/compiler/portable_math.h"

namespace thimble::host {
namespace {

Eigen::Quaterniond turned(double angle_rad, const Eigen::Vector3d& axis) {
  Eigen::Quaterniond q;
  q.w() = portable::cos(0.5 * angle_rad);
  q.vec() = portable::sin(0.5 * angle_rad) * axis;
  return q;
}

}  // namespace

void read_pose(const Value& value, Eigen::Vector3d& position_m, Eigen::Quaterniond& rotation) {
  const ScenePart part(value, "pose");
  position_m = part.vector("position_m");
  using Eigen::Vector3d;
  const Vector3d angles = part.vector("rotation_deg") * (std::numbers::pi / 180.0);
  rotation = turned(angles.z(), Vector3d::UnitZ()) * turned(angles.y(), Vector3d::UnitY()) *
             turned(angles.x(), Vector3d::UnitX());
  rotation.normalize();
}

}  // namespace thimble::host
