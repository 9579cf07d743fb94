#include "kinematics/arm.h"

#include <limits>

#include "kinematics/dynamics.h"
#include "kinematics/gravity.h"

namespace thimble::kinematics {
namespace {

template <typename S>
TwoLinkAngles<S> angles_of(const AxisVector<S>& joints) noexcept {
  return {sin_cos(S(joints[0])), sin_cos(S(joints[1])), sin_cos(S(joints[2]))};
}

}  // namespace

template <typename S>
Arm<S>::Arm(const ArmData& data, const BasePose& base) noexcept
    : data_(&data), two_link_(data, base), mechanism_(data.geometry, base), axes_(axes_of(data.geometry)) {
  is_two_link_ = kinematics::is_two_link(data.geometry);
  is_level_ = mechanism_.up() == Vector3<S>::UnitZ();
  Posture<S> posture = home_posture();
  if (is_two_link_) move_to(PerAxis<S>::Zero(), posture);  // where the published stiffness is
  for (int j = 0; j < axes_; ++j) {
    const S known = S(data.axis[static_cast<std::size_t>(j)].stiffness_N_m_rad);
    const S of_tip = S(data.tip_stiffness_N_m) * posture.jacobian.col(j).squaredNorm();
    stiffness_N_m_rad_[j] = known > 0 ? known : of_tip;
  }
}

template <typename S>
Posture<S> Arm<S>::home_posture() const noexcept {
  Posture<S> posture;
  posture.plate_m = mechanism_.first_plate_m();
  move_to(home(), posture);
  return posture;
}

template <typename S>
Eigen::Quaternion<S> Arm<S>::orientation(const PerAxis<S>& axes) const noexcept {
  Eigen::Quaternion<S> q(mechanism_.rotation(axes.head(axes_)));
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

template <typename S>
Jacobian3<S> Arm<S>::driven_jacobian(const Posture<S>& posture) const noexcept {
  Jacobian3<S> driven = posture.jacobian.leftCols(axes_);
  for (int j = 0; j < axes_; ++j)
    if (!is_driven(j)) driven.col(j).setZero();
  return driven;
}

// Of the coefficients of a two-link platform, for a base that stands in any way: the potential energy is up . (c1 R, s1 R, Z) with
// R = g2 cos q2 + g3 sin q3 and Z = g2 sin q2 - g3 cos q3. up: upwards, in the base frame.
template <typename S>
Vector3<S> Arm<S>::tilted_weight(const TwoLinkAngles<S>& p) const noexcept {
  const Vector3<S>& up = mechanism_.up();
  const S g2 = S(data_->inertia.g2), g3 = S(data_->inertia.g3);
  const S R = g2 * p.q2.cos + g3 * p.q3.sin;
  const S out = p.q1.cos * up.x() + p.q1.sin * up.y();
  return {(p.q1.cos * up.y() - p.q1.sin * up.x()) * R, g2 * (up.z() * p.q2.cos - out * p.q2.sin),
          g3 * (up.z() * p.q3.sin + out * p.q3.cos)};
}

template <typename S>
void Arm<S>::move_mechanism(const PerAxis<S>& axes, Posture<S>& posture) const noexcept {
  MechanismPose<S> pose;
  pose.plate_m = posture.plate_m;
  if (!mechanism_.at(axes.head(axes_), pose)) {
    posture.tip_m.setConstant(std::numeric_limits<S>::quiet_NaN());
    return;
  }
  posture.tip_m = pose.force_point_m;
  posture.jacobian.leftCols(axes_) = pose.force_jacobian;
  posture.plate_m = pose.plate_m;
  posture.weight_N_m.head(axes_) = kinematics::gravity_torques<S>(mechanism_, axes.head(axes_), pose);
  if (!data_->has_inertia) return;
  AxisVector<S> by_joint = AxisVector<S>::Zero(axes_);
  by_joint.template head<3>() = tilted_weight(angles_of<S>(mechanism_.joints(axes.head(axes_))));
  posture.weight_N_m.head(axes_) += mechanism_.to_axes(by_joint);
}

template <typename S>
S Arm<S>::mass_along(const PerAxis<S>& axes, const Posture<S>& posture,
                     const PerAxis<S>& per_m) const noexcept {
  S mass = 0;
  if (is_two_link_) {
    const Vector3<S> by_joint = per_m.template head<3>();
    mass = by_joint.dot(mass_matrix<S>(data_->inertia, posture) * by_joint);
  } else {
    MechanismPose<S> pose;
    pose.plate_m = posture.plate_m;
    if (mechanism_.at(axes.head(axes_), pose))
      mass = moving_mass<S>(mechanism_, axes.head(axes_), pose, per_m.head(axes_));
    if (data_->has_inertia) {
      const TwoLinkAngles<S> angles = angles_of<S>(mechanism_.joints(axes.head(axes_)));
      const Vector3<S> by_joint = mechanism_.joint_speeds(per_m.head(axes_)).template head<3>();
      mass += by_joint.dot(mass_matrix<S>(data_->inertia, angles) * by_joint);
    }
  }
  for (int j = 0; j < axes_; ++j)
    if (is_driven(j))
      mass += S(data_->axis[static_cast<std::size_t>(j)].reflected_rotor_inertia()) * per_m[j] * per_m[j];
  return mass;
}

template class Arm<float>;
template class Arm<double>;

}  // namespace thimble::kinematics
