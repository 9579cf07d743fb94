#include "host-tools/arms/arm_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "kinematics/arm_data.h"

namespace thimble::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Line = ArmPose::Line;

constexpr double kSamePoint_m = 1e-6;

double wide(float value) { return static_cast<double>(value); }

// All in the base frame, as the formulas of the family's file (kinematics/) have them.
Line two_link_line(const kinematics::TwoLinkGeometry& links, const kinematics::AxisVector<double>& q) {
  const Vector3d shoulder(0, 0, wide(links.base_height_m));
  const Vector3d elbow =
      shoulder + wide(links.upper_link_m) * Vector3d(std::cos(q[0]) * std::cos(q[1]),
                                                     std::sin(q[0]) * std::cos(q[1]), std::sin(q[1]));
  return {Vector3d::Zero(), shoulder, elbow};
}

Line five_bar_leg(const kinematics::FiveBarGeometry& bars, int leg, double q) {
  const Vector3d foot(leg == 0 ? 0 : wide(bars.base_distance_m), 0, 0);
  return {foot, foot + wide(bars.inner_m.at(static_cast<std::size_t>(leg))) *
                           Vector3d(std::cos(q), std::sin(q), 0)};
}

Line delta_leg(const kinematics::DeltaGeometry& delta, int leg, double q, const Vector3d& plate_m) {
  const Eigen::Matrix2d turn =
      Eigen::Rotation2Dd(wide(delta.leg_angle_rad.at(static_cast<std::size_t>(leg)))).toRotationMatrix();
  const Vector2d base(wide(delta.base_u_m), wide(delta.base_v_m));
  const auto at = [&](double u, double v, double w) {
    const Vector2d flat = turn * (base + Vector2d(u, v));
    return Vector3d(flat.x(), flat.y(), w);
  };
  const Vector2d end = turn * Vector2d(wide(delta.plate_u_m), wide(delta.plate_v_m));
  return {at(0, 0, 0), at(wide(delta.thigh_m) * std::cos(q), 0, wide(delta.thigh_m) * std::sin(q)),
          plate_m + Vector3d(end.x(), end.y(), 0)};
}

}  // namespace

ArmPose::ArmPose(const kinematics::ArmData& arm)
    : geometry_(arm.geometry), mechanism_(geometry_), pose_(mechanism_.home_pose()), at_(mechanism_.home()) {}

std::size_t ArmPose::axes() const { return static_cast<std::size_t>(mechanism_.axes()); }

std::vector<double> ArmPose::home() const {
  const kinematics::AxisVector<double> home = mechanism_.home();
  return {home.begin(), home.end()};
}

bool ArmPose::move_to(std::span<const double> axes) {
  if (axes.size() != this->axes()) return false;
  const kinematics::AxisVector<double> next =
      Eigen::Map<const Eigen::VectorXd>(axes.data(), static_cast<Eigen::Index>(axes.size()));
  // A delta is sought from where it was; after a jump from home.
  for (kinematics::MechanismPose<double> there : {pose_, mechanism_.home_pose()}) {
    if (!mechanism_.at(next, there) || !there.force_point_m.allFinite()) continue;
    pose_ = there;
    at_ = next;
    return true;
  }
  return false;
}

std::vector<Line> ArmPose::platform_lines() const {
  const kinematics::AxisVector<double> q = mechanism_.joints(at_);
  std::vector<Line> lines;
  if (const auto* two = std::get_if<kinematics::TwoLinkGeometry>(&geometry_.platform)) {
    lines.push_back(two_link_line(*two, q));
  } else if (const auto* bars = std::get_if<kinematics::FiveBarGeometry>(&geometry_.platform)) {
    for (int leg = 0; leg < 2; ++leg) lines.push_back(five_bar_leg(*bars, leg, q[leg]));
  } else if (const auto* delta = std::get_if<kinematics::DeltaGeometry>(&geometry_.platform)) {
    for (int leg = 0; leg < 3; ++leg) lines.push_back(delta_leg(*delta, leg, q[leg], pose_.plate_m));
  }
  for (Line& line : lines) line.push_back(pose_.plate_m);
  return lines;
}

Eigen::Matrix3d ArmPose::world_from_base() const { return pose_.rotation * pose_.chain.rotation.transpose(); }

Vector3d ArmPose::in_world(const Vector3d& base_m) const {
  return pose_.tip_m + world_from_base() * (base_m - pose_.plate_m - pose_.chain.tip_m);
}

// The directions are those in which the formulas above count an angle up.
ArmPose::AxisLine ArmPose::platform_axis(int joint) const {
  const kinematics::AxisVector<double> q = mechanism_.joints(at_);
  AxisLine line;
  if (const auto* two = std::get_if<kinematics::TwoLinkGeometry>(&geometry_.platform)) {
    if (joint == 0) return line;
    line.at_m = two_link_line(*two, q).at(static_cast<std::size_t>(joint));
    line.direction = {std::sin(q[0]), -std::cos(q[0]), 0};
  } else if (const auto* bars = std::get_if<kinematics::FiveBarGeometry>(&geometry_.platform)) {
    line.at_m = five_bar_leg(*bars, joint, q[joint]).front();
  } else if (const auto* delta = std::get_if<kinematics::DeltaGeometry>(&geometry_.platform)) {
    line.at_m = delta_leg(*delta, joint, q[joint], pose_.plate_m).front();
    const double leg = wide(delta->leg_angle_rad.at(static_cast<std::size_t>(joint)));
    line.direction = {std::sin(leg), -std::cos(leg), 0};
  }
  return line;
}

ArmPose::AxisLine ArmPose::axis_line(std::size_t axis) const {
  const auto by_axis = geometry_.joints_per_axis.col(static_cast<Eigen::Index>(axis));
  int joint = 0;
  while (joint + 1 < mechanism_.axes() && by_axis[joint] == 0) ++joint;
  const int platform = kinematics::platform_joints(geometry_);
  AxisLine line;
  if (joint < platform) {
    line = platform_axis(joint);
  } else {
    const auto k = static_cast<std::size_t>(joint - platform);
    line.slides = geometry_.chain.joint.at(k).kind == kinematics::JointKind::kPrismatic;
    line.at_m = pose_.plate_m + pose_.chain.origin_m.at(k);
    line.direction = pose_.chain.axis.at(k);
  }
  line.at_m = in_world(line.at_m);
  line.direction = world_from_base() * line.direction * (by_axis[joint] < 0 ? -1 : 1);
  return line;
}

std::vector<Line> ArmPose::links() const {
  std::vector<Line> lines = platform_lines();
  if (geometry_.chain.count > 0 || geometry_.chain.tip_m.norm() > 0) {
    Line chain{pose_.plate_m};
    for (int k = 0; k < geometry_.chain.count; ++k) {
      chain.emplace_back(pose_.plate_m + pose_.chain.origin_m.at(static_cast<std::size_t>(k)));
      chain.emplace_back(pose_.plate_m + pose_.chain.link_m.at(static_cast<std::size_t>(k)));
    }
    chain.emplace_back(pose_.plate_m + pose_.chain.tip_m);
    lines.push_back(std::move(chain));
  }
  for (Line& line : lines) {
    for (Vector3d& point : line) point = in_world(point);
    const auto same = [](const Vector3d& a, const Vector3d& b) { return (a - b).norm() < kSamePoint_m; };
    line.erase(std::unique(line.begin(), line.end(), same), line.end());
  }
  return lines;
}

}  // namespace thimble::host
