// Where an arm is with its axes at given places: its tip, its Jacobian, and its links for a picture.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "kinematics/mechanism.h"

namespace thimble::kinematics {
struct ArmData;
}

namespace thimble::host {

// World frame, m: the tip is at the origin with all axes at home, and the base stands as without a mounting. Axes in rad, m for a prismatic one.
class ArmPose {
 public:
  using Line = std::vector<Eigen::Vector3d>;

  explicit ArmPose(const kinematics::ArmData& arm);  // at home
  ArmPose(const ArmPose&) = delete;
  ArmPose& operator=(const ArmPose&) = delete;
  ~ArmPose() = default;

  [[nodiscard]] std::size_t axes() const;
  [[nodiscard]] std::vector<double> home() const;

  // axes: axes() of them. False: the links do not meet there, or it is singular; everything stays as it was.
  [[nodiscard]] bool move_to(std::span<const double> axes);

  // Where the force acts, which the controller calls the tip: of a sensed wrist its gimbal.
  [[nodiscard]] Eigen::Vector3d tip_m() const { return pose_.force_point_m; }
  // A column an axis: velocity of that point by the speed of the axis. An axis without a motor has one, too.
  [[nodiscard]] Eigen::Matrix3Xd jacobian() const { return pose_.force_jacobian; }
  // Of the last link of a chain or a wrist; the unit matrix for an arm that has neither.
  [[nodiscard]] Eigen::Matrix3d rotation() const { return pose_.rotation; }
  // The links from joint to joint, from the base on: one line for a chain and a two-link arm, one a leg for a five-bar and a delta, and one for the
  // wrist behind these. The last point of the last line is the end of the last link.
  [[nodiscard]] std::vector<Line> links() const;

  // How a positive motion of an axis moves the first link that it moves, by the joint in front of that link.
  struct AxisLine {
    bool slides = false;  // along `direction`; otherwise the link turns about it, by the right-hand rule
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // of length 1
  };
  [[nodiscard]] AxisLine axis_line(std::size_t axis) const;

 private:
  [[nodiscard]] AxisLine platform_axis(int joint) const;
  [[nodiscard]] Eigen::Matrix3d world_from_base() const;
  [[nodiscard]] Eigen::Vector3d in_world(const Eigen::Vector3d& base_m) const;
  [[nodiscard]] std::vector<Line> platform_lines() const;

  kinematics::Geometry geometry_;
  kinematics::Mechanism<double> mechanism_;
  kinematics::MechanismPose<double> pose_;
  kinematics::AxisVector<double> at_;
};

}  // namespace thimble::host
