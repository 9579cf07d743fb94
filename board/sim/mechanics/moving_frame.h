// A frame that moves with the joints of an arm: where it is, and its velocity and acceleration as linear functions of the joints' speeds and
// accelerations. Written for the simulated arm, in double and by recursion from frame to frame, so that an error of the controller's
// kinematics (kinematics/mechanism.h) is not the simulator's too. Units: SI, in the frame of the arm's base.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinematics/geometry.h"

namespace thimble::board {

using JointVector = kinematics::AxisVector<double>;
using JointMatrix = kinematics::AxisMatrix<double>;
using ByJoint = kinematics::Jacobian3<double>;  // a column for each joint

// acceleration = by_joint * qdd + bias
struct MovingPoint {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  ByJoint by_joint;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();

  static MovingPoint fixed(const Eigen::Vector3d& at_m, Eigen::Index joints) {
    return {at_m, ByJoint::Zero(3, joints), Eigen::Vector3d::Zero()};
  }
};

struct MovingFrame {
  MovingPoint origin;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  ByJoint turn;  // angular velocity
  Eigen::Vector3d turn_bias = Eigen::Vector3d::Zero();

  static MovingFrame fixed(const Eigen::Vector3d& at_m, const Eigen::Matrix3d& rotation,
                           Eigen::Index joints) {
    return {MovingPoint::fixed(at_m, joints), rotation, ByJoint::Zero(3, joints), Eigen::Vector3d::Zero()};
  }

  // A point of the frame; r: from its origin, in the frame.
  [[nodiscard]] MovingPoint point(const Eigen::Vector3d& r, const JointVector& qd) const {
    const Eigen::Vector3d arm = rotation * r, omega = turn * qd;
    MovingPoint p = origin;
    p.at_m += arm;
    for (Eigen::Index j = 0; j < turn.cols(); ++j) p.by_joint.col(j) += turn.col(j).cross(arm);
    p.bias += turn_bias.cross(arm) + omega.cross(omega.cross(arm));
    return p;
  }

  // Moves the origin to a point of the frame.
  void shift(const Eigen::Vector3d& r, const JointVector& qd) { origin = point(r, qd); }

  // Turns about an axis of the frame, by joint j.
  void revolve(const Eigen::Vector3d& axis, const Eigen::Matrix3d& by, Eigen::Index j,
               const JointVector& qd) {
    const Eigen::Vector3d along = rotation * axis;
    turn_bias += (turn * qd).cross(along * qd[j]);
    turn.col(j) += along;
    rotation = (rotation * by).eval();
  }

  // Slides along an axis of the frame, by joint j.
  void slide(const Eigen::Vector3d& axis, double by_m, Eigen::Index j, const JointVector& qd) {
    const Eigen::Vector3d along = rotation * axis;
    shift(by_m * axis, qd);
    origin.by_joint.col(j) += along;
    origin.bias += 2.0 * (turn * qd).cross(along * qd[j]);
  }
};

}  // namespace thimble::board
