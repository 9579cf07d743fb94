#include "kinematics/arm.h"

#include <cmath>
#include <limits>

#include "kinematics/directions.h"
#include "kinematics/dynamics.h"
#include "kinematics/force_fade.h"
#include "kinematics/gravity.h"

namespace thimble::kinematics {
namespace {

constexpr int kInverseSteps = 60;

// Of the coefficients of a two-link platform, for a base that stands in any way: the potential energy is up . (c1 R, s1 R, Z) with
// R = g2 cos q2 + g3 sin q3 and Z = g2 sin q2 - g3 cos q3. up: upwards, in the base frame.
template <typename S>
Vector3<S> tilted_weight(const InertiaModel& m, const Vector3<S>& up, const TwoLinkAngles<S>& p) noexcept {
  const S g2 = S(m.g2), g3 = S(m.g3);
  const S R = g2 * p.q2.cos + g3 * p.q3.sin;
  const S out = p.q1.cos * up.x() + p.q1.sin * up.y();
  return {(p.q1.cos * up.y() - p.q1.sin * up.x()) * R, g2 * (up.z() * p.q2.cos - out * p.q2.sin),
          g3 * (up.z() * p.q3.sin + out * p.q3.cos)};
}

template <typename S>
TwoLinkAngles<S> angles_of(const AxisVector<S>& joints) noexcept {
  return {sin_cos(S(joints[0])), sin_cos(S(joints[1])), sin_cos(S(joints[2]))};
}

}  // namespace

template <typename S>
void Arm<S>::move_mechanism(const PerAxis<S>& axes, Posture<S>& posture) const noexcept {
  if (!mechanism_.at(axes.head(axes_), posture.pose)) {
    posture.tip_m.setConstant(std::numeric_limits<S>::quiet_NaN());
    return;
  }
  posture.tip_m = posture.pose.force_point_m;
  posture.jacobian.leftCols(axes_) = posture.pose.force_jacobian;
}

template <typename S>
PerAxis<S> Arm<S>::gravity_torques(const PerAxis<S>& axes, const Posture<S>& posture) const noexcept {
  PerAxis<S> torque = PerAxis<S>::Zero();
  if (is_two_link_ && is_level_) {
    torque.template head<3>() = kinematics::gravity_torques<S>(data_->inertia, posture);
    return torque;
  }
  if (is_two_link_) {
    torque.template head<3>() = tilted_weight<S>(data_->inertia, mechanism_.up(), posture);
    return torque;
  }
  torque.head(axes_) = kinematics::gravity_torques<S>(mechanism_, axes.head(axes_), posture.pose);
  if (data_->has_inertia) {
    AxisVector<S> by_joint = AxisVector<S>::Zero(axes_);
    by_joint.template head<3>() =
        tilted_weight<S>(data_->inertia, mechanism_.up(), angles_of<S>(mechanism_.joints(axes.head(axes_))));
    torque.head(axes_) += mechanism_.to_axes(by_joint);
  }
  return torque;
}

template <typename S>
S Arm<S>::mass_along(const PerAxis<S>& axes, const Posture<S>& posture,
                     const PerAxis<S>& per_m) const noexcept {
  S mass = 0;
  if (is_two_link_) {
    const Vector3<S> by_joint = per_m.template head<3>();
    mass = by_joint.dot(mass_matrix<S>(data_->inertia, posture) * by_joint);
  } else {
    mass = moving_mass<S>(mechanism_, axes.head(axes_), posture.pose, per_m.head(axes_));
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

template <typename S>
bool Arm<S>::inverse(const Vector3<S>& tip_m, PerAxis<S>& axes) const noexcept {
  if (is_two_link_) {
    Vector3<S> joints;
    if (!two_link_.inverse(tip_m, joints)) return false;
    axes.template head<3>() = joints;
    return true;
  }
  constexpr S kNear_m = S(1e-5), kMostStep_m = S(0.02);
  const Jacobian3<S> at_home = home_posture().jacobian.leftCols(axes_);
  const Directions home_ways = directions_of(at_home.template cast<float>());
  const float least = ForceFade::kLost * home_ways.value[0];
  Matrix3<S> ways = Matrix3<S>::Zero();
  for (int i = 0; i < 3 && home_ways.value[i] > 1e-3F * home_ways.value[0]; ++i)
    ways += (home_ways.along.col(i) * home_ways.along.col(i).transpose()).template cast<S>();
  PerAxis<S> found = home();
  Posture<S> posture = home_posture();
  for (int step = 0; step < kInverseSteps; ++step) {
    Vector3<S> left_m = ways * (tip_m - posture.tip_m);
    const S distance_m = std::sqrt(left_m.squaredNorm());
    if (!(distance_m < S(1e3))) return false;  // NaN: the links do not meet there
    if (distance_m < kNear_m) {
      axes = found;
      return true;
    }
    if (distance_m > kMostStep_m) left_m *= kMostStep_m / distance_m;
    const Jacobian3<S> now = posture.jacobian.leftCols(axes_);
    found += directions_of(now.template cast<float>())
                 .speeds_for(left_m.template cast<float>(), least)
                 .template cast<S>();
    move_to(found, posture);
  }
  return false;
}

template class Arm<float>;
template class Arm<double>;

}  // namespace thimble::kinematics
