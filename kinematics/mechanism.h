// The kinematics of any arm: angles of its axes to the pose of its tip, to the point where its force acts, and to the Jacobians that map speeds of
// the axes to velocities there and, transposed, a force or a wrench to torques of the axes. Mechanism<float> runs in the tick, Mechanism<double>
// in tests and tools.
//
//   const Mechanism<float> arm(geometry, base);
//   MechanismPose<float> pose = arm.home_pose();
//   if (!arm.at(axes_rad, pose)) ...                     // once per tick; pose has where it was, from which a delta looks on
//   pose.tip_m;  pose.jacobian.topRows(3) * speeds;      // position and velocity, world frame
//   arm.torques(pose, force_N)                           // of the axes, N m; 0 where there is no motor
//
// Frames: the geometry is given in the base frame; the world's is BasePose's, with the tip at home_m when all axes are at home. Units: m, rad, N,
// N m; for a prismatic axis m and N. All loops are bounded by kMaxJoints or kDeltaSteps, nothing allocates or throws.
#pragma once

#include <Eigen/Core>

#include "kinematics/base_pose.h"
#include "kinematics/chain.h"
#include "kinematics/delta.h"
#include "kinematics/five_bar.h"
#include "kinematics/geometry.h"
#include "kinematics/two_link.h"

namespace thimble::kinematics {

template <typename S>
struct MechanismPose {
  Vector3<S> tip_m;             // world frame, as all here
  Matrix3<S> rotation;          // of the last link
  Vector3<S> force_point_m;     // where the force acts: the tip, or a gimbal
  Jacobian6<S> jacobian;        // twist of the tip, (velocity, angular velocity), by the speeds of the axes
  Jacobian3<S> force_jacobian;  // velocity of the force point by the speeds of the axes
  // In the base frame. A delta's forward map begins at plate_m in the next tick.
  Vector3<S> plate_m;
  Jacobian3<S> plate_jacobian;  // of the platform's joints
  ChainPose<S> chain;           // in the frame of the plate
};

template <typename S>
class Mechanism {
 public:
  explicit Mechanism(const Geometry& geometry, const BasePose& base = {}) noexcept;

  [[nodiscard]] const Geometry& geometry() const noexcept { return *geometry_; }
  [[nodiscard]] int axes() const noexcept { return axes_; }
  [[nodiscard]] AxisVector<S> home() const noexcept { return geometry_->home.template cast<S>().head(axes_); }
  // Where the forward map of a delta begins to look.
  [[nodiscard]] Vector3<S> first_plate_m() const noexcept;
  // All axes at home; for a geometry that does not close there, only plate_m is of use.
  [[nodiscard]] MechanismPose<S> home_pose() const noexcept;
  [[nodiscard]] bool closes_at_home() const noexcept { return closes_at_home_; }
  [[nodiscard]] AxisVector<S> joints(const AxisVector<S>& axes) const noexcept;               // q = C a + q0
  [[nodiscard]] AxisVector<S> joint_speeds(const AxisVector<S>& axis_speeds) const noexcept;  // C a
  [[nodiscard]] AxisVector<S> to_axes(const AxisVector<S>& joint_torques) const noexcept;     // C^T tau
  [[nodiscard]] Vector3<S> up() const noexcept { return R_WB_.row(2); }  // the world's z, in the base frame

  // False: these angles do not close the mechanism, or it is so near to a singularity that forces would not be bounded; the pose is not to be
  // used then, but for plate_m, which is as it was. An angle that is not finite gives false or NaN.
  [[nodiscard]] bool at(const AxisVector<S>& axes, MechanismPose<S>& pose) const noexcept;

  // Whether there is a last link that turns: that of a chain, or of a wrist.
  [[nodiscard]] bool has_rotation() const noexcept { return geometry_->chain.count > 0; }
  // MechanismPose::rotation alone, wherever the platform is. NaN where an angle is not finite.
  [[nodiscard]] Matrix3<S> rotation(const AxisVector<S>& axes) const noexcept;

  // Torques of the axes for a force at the force point, world frame. An axis without a motor gets 0.
  [[nodiscard]] AxisVector<S> torques(const MechanismPose<S>& pose, const Vector3<S>& force_N) const noexcept;
  // The same for a wrench (force, moment) at the tip.
  [[nodiscard]] AxisVector<S> torques_of_wrench(const MechanismPose<S>& pose,
                                                const Eigen::Matrix<S, 6, 1>& wrench) const noexcept;

 private:
  [[nodiscard]] AxisMatrix<S> coupling() const noexcept;
  [[nodiscard]] bool plate_at(const AxisVector<S>& q, Vector3<S>& position_m,
                              Jacobian3<S>& jacobian) const noexcept;
  void clear_undriven(AxisVector<S>& torques) const noexcept;

  const Geometry* geometry_;
  int axes_, platform_;
  Delta<S> delta_;  // with angles of its legs at hand; not used by the other families
  Matrix3<S> R_WB_;
  Vector3<S> p_WB_ = Vector3<S>::Zero();
  bool closes_at_home_ = false;
};

extern template class Mechanism<float>;
extern template class Mechanism<double>;

}  // namespace thimble::kinematics
