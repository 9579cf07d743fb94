// An arm of any family, as the firmware sees it: angles of its axes to the point where its force acts and to the Jacobian there, which maps
// speeds of the axes to a velocity and, transposed, a force to torques of the axes. One Arm per physical arm.
//
//   const Arm<float> arm(data, base);                         // data must outlive it
//   Posture<float> posture = arm.home_posture();
//   arm.move_to(axes, posture);                               // once per tick
//   posture.tip_m;  velocity(posture.jacobian, speeds, arm.axes());
//   torques(posture.jacobian, force_N, arm.axes(), torque);   // N m
//
// The two-link arm has its own closed form (two_link_arm.h), every other one goes through Mechanism. Frames and units: base_pose.h, arm_data.h. Nothing
// here fails: where the links do not meet, the tip is NaN.
#pragma once

#include <Eigen/Geometry>

#include "kinematics/arm_data.h"
#include "kinematics/base_pose.h"
#include "kinematics/mechanism.h"
#include "kinematics/two_link_arm.h"

namespace thimble::kinematics {

template <typename S>
struct Posture : TwoLinkAngles<S> {       // the angles are those of a two-link arm only
  Vector3<S> tip_m = Vector3<S>::Zero();  // where the force acts, world frame
  Eigen::Matrix<S, 3, kMaxJoints> jacobian = Eigen::Matrix<S, 3, kMaxJoints>::Zero();  // d tip_m / d axes
  // Of an arm that is not a two-link: the torques that hold its weight, and where its plate is, from which a delta's forward map goes on.
  PerAxis<S> weight_N_m = PerAxis<S>::Zero();
  Vector3<S> plate_m = Vector3<S>::Zero();
};

// The sums begin with the last axis, as Eigen's sum of three does.
template <typename S>
[[nodiscard]] Vector3<S> velocity(const Eigen::Matrix<S, 3, kMaxJoints>& jacobian, const PerAxis<S>& speeds,
                                  int axes) noexcept {
  if (axes == 3) return jacobian.template leftCols<3>() * speeds.template head<3>();
  Vector3<S> sum = jacobian.col(axes - 1) * speeds[axes - 1];
  for (int j = axes - 2; j >= 0; --j) sum = jacobian.col(j) * speeds[j] + sum;
  return sum;
}
// torque: of so many axes; the others stay.
template <typename S>
void torques(const Eigen::Matrix<S, 3, kMaxJoints>& jacobian, const Vector3<S>& force_N, int axes,
             PerAxis<S>& torque) noexcept {
  for (int j = 0; j < axes; ++j) torque[j] = jacobian.col(j).dot(force_N);
}

template <typename S>
class Arm {
 public:
  explicit Arm(const ArmData& data, const BasePose& base = {}) noexcept;

  [[nodiscard]] const ArmData& data() const noexcept { return *data_; }
  [[nodiscard]] int axes() const noexcept { return axes_; }
  [[nodiscard]] bool is_two_link() const noexcept { return is_two_link_; }
  [[nodiscard]] bool is_driven(int axis) const noexcept {
    return data_->geometry.driven[static_cast<std::size_t>(axis)];
  }
  [[nodiscard]] PerAxis<S> home() const noexcept { return data_->geometry.home.template cast<S>(); }

  // All axes at home.
  [[nodiscard]] Posture<S> home_posture() const noexcept;

  // posture: of the tick before, or home_posture(): from there the links of a delta go on.
  void move_to(const PerAxis<S>& axes, Posture<S>& posture) const noexcept;

  // Of the cables and links, seen at the axes (compliance.h); N m/rad.
  [[nodiscard]] const PerAxis<S>& stiffness_N_m_rad() const noexcept { return stiffness_N_m_rad_; }

  // Torques that hold the weight of the arm, of all axes.
  [[nodiscard]] PerAxis<S> gravity_torques(const Posture<S>& posture) const noexcept;

  // workspace_limit() of this arm.
  [[nodiscard]] int limit(const PerAxis<S>& axes, S margin = 0) const noexcept;

  // The mass that the tip shows while the axes move with it at these speeds for 1 m/s, kg; rotors included.
  [[nodiscard]] S mass_along(const PerAxis<S>& axes, const Posture<S>& posture,
                             const PerAxis<S>& per_m) const noexcept;

  // Of the last link of a chain or a wrist, in the world: a unit quaternion with w >= 0, NaN where an angle is not finite. Not for the tick.
  [[nodiscard]] bool has_orientation() const noexcept { return mechanism_.has_rotation(); }
  [[nodiscard]] Eigen::Quaternion<S> orientation(const PerAxis<S>& axes) const noexcept;

  // The Jacobian of the axes that have a motor; the columns of the others are 0.
  [[nodiscard]] Jacobian3<S> driven_jacobian(const Posture<S>& posture) const noexcept;

  // The axes for a position of the tip, as far as the arm can move there: a direction in which it cannot be moved at home is left out. False
  // (axes unchanged): out of reach. Limits are not checked. In closed form, or by at most kInverseSteps of Newton's method from home; not for the
  // tick.
  [[nodiscard]] bool inverse(const Vector3<S>& tip_m, PerAxis<S>& axes) const noexcept;

 private:
  void move_mechanism(const PerAxis<S>& axes, Posture<S>& posture) const noexcept;
  [[nodiscard]] Vector3<S> tilted_weight(const TwoLinkAngles<S>& angles) const noexcept;

  const ArmData* data_;
  TwoLinkArm<S> two_link_;
  Mechanism<S> mechanism_;
  int axes_;
  bool is_two_link_, is_level_;
  PerAxis<S> stiffness_N_m_rad_ = PerAxis<S>::Zero();
};

extern template class Arm<float>;
extern template class Arm<double>;

}  // namespace thimble::kinematics
