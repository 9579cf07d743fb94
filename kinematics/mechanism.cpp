#include "kinematics/mechanism.h"

namespace thimble::kinematics {
namespace {

const DeltaGeometry& delta_of(const Geometry& geometry) noexcept {
  static constexpr DeltaGeometry kNone{};
  const DeltaGeometry* delta = std::get_if<DeltaGeometry>(&geometry.platform);
  return delta != nullptr ? *delta : kNone;
}

}  // namespace

template <typename S>
Mechanism<S>::Mechanism(const Geometry& geometry, const BasePose& base) noexcept
    : geometry_(&geometry),
      axes_(axes_of(geometry)),
      platform_(platform_joints(geometry)),
      delta_(delta_of(geometry)),
      R_WB_(base.rotation.template cast<S>() * geometry.rotation.template cast<S>()) {
  MechanismPose<S> pose = home_pose();
  closes_at_home_ = at(home(), pose);
  if (closes_at_home_) p_WB_ = base.home_m.template cast<S>() - pose.tip_m;
}

template <typename S>
Vector3<S> Mechanism<S>::first_plate_m() const noexcept {
  return {S(0), S(0), S(delta_of(*geometry_).home_axis_m)};
}

template <typename S>
MechanismPose<S> Mechanism<S>::home_pose() const noexcept {
  MechanismPose<S> pose;
  pose.plate_m = first_plate_m();
  static_cast<void>(at(home(), pose));
  return pose;
}

template <typename S>
bool Mechanism<S>::plate_at(const AxisVector<S>& q, Vector3<S>& position_m,
                            Jacobian3<S>& jacobian) const noexcept {
  Plate<S, 3> plate;
  plate.position_m = position_m;
  if (const auto* two = std::get_if<TwoLinkGeometry>(&geometry_->platform)) {
    two_link<S>(*two, sin_cos(q[0]), sin_cos(q[1]), sin_cos(q[2]), plate);
  } else if (const auto* bars = std::get_if<FiveBarGeometry>(&geometry_->platform)) {
    Plate<S, 2> flat;
    if (!five_bar<S>(*bars, q.template head<2>(), flat)) return false;
    plate.position_m = flat.position_m;
    plate.jacobian.template leftCols<2>() = flat.jacobian;
  } else if (std::holds_alternative<DeltaGeometry>(geometry_->platform)) {
    if (!delta_.at(q.template head<3>(), plate)) return false;
  } else {
    plate.position_m.setZero();
  }
  position_m = plate.position_m;
  jacobian = plate.jacobian.leftCols(platform_);
  return true;
}

template <typename S>
AxisMatrix<S> Mechanism<S>::coupling() const noexcept {
  return geometry_->joints_per_axis.topLeftCorner(axes_, axes_).template cast<S>();
}

template <typename S>
AxisVector<S> Mechanism<S>::joints(const AxisVector<S>& axes) const noexcept {
  return coupling() * axes + geometry_->joint_offset.head(axes_).template cast<S>();
}

template <typename S>
AxisVector<S> Mechanism<S>::joint_speeds(const AxisVector<S>& axis_speeds) const noexcept {
  return coupling() * axis_speeds;
}

template <typename S>
AxisVector<S> Mechanism<S>::to_axes(const AxisVector<S>& joint_torques) const noexcept {
  return coupling().transpose() * joint_torques;
}

template <typename S>
bool Mechanism<S>::at(const AxisVector<S>& axes, MechanismPose<S>& pose) const noexcept {
  const AxisVector<S> q = joints(axes);
  Vector3<S> plate_m = pose.plate_m;
  Jacobian3<S> by_platform(3, platform_);
  if (!plate_at(q, plate_m, by_platform)) return false;

  const ChainGeometry& chain = geometry_->chain;
  chain_pose<S>(chain, q.tail(chain.count), pose.chain);
  const bool at_tip = chain.force_joint >= chain.count;
  const Vector3<S> force_m =
      at_tip ? pose.chain.tip_m : pose.chain.origin_m[static_cast<std::size_t>(chain.force_joint)];
  Jacobian6<S> by_joint(6, axes_);
  Jacobian3<S> force_by_joint(3, axes_);
  by_joint.topLeftCorner(3, platform_) = by_platform;
  by_joint.bottomLeftCorner(3, platform_).setZero();
  force_by_joint.leftCols(platform_) = by_platform;
  for (int k = 0; k < chain.count; ++k) {
    const auto joint = static_cast<std::size_t>(k);
    const bool turns = chain.joint[joint].kind == JointKind::kRevolute;
    by_joint.col(platform_ + k).template head<3>() =
        velocity_by_joint<S>(chain, pose.chain, k, chain.count, pose.chain.tip_m);
    by_joint.col(platform_ + k).template tail<3>() = turns ? pose.chain.axis[joint] : Vector3<S>::Zero();
    force_by_joint.col(platform_ + k) =
        velocity_by_joint<S>(chain, pose.chain, k, at_tip ? chain.count : chain.force_joint, force_m);
  }
  pose.plate_m = plate_m;
  pose.plate_jacobian = by_platform;
  pose.tip_m = p_WB_ + R_WB_ * (plate_m + pose.chain.tip_m);
  pose.force_point_m = p_WB_ + R_WB_ * (plate_m + force_m);
  pose.rotation = R_WB_ * pose.chain.rotation;
  const AxisMatrix<S> C = coupling();
  by_joint = (by_joint * C).eval();
  pose.jacobian.resize(6, axes_);
  pose.jacobian.template topRows<3>() = R_WB_ * by_joint.template topRows<3>();
  pose.jacobian.template bottomRows<3>() = R_WB_ * by_joint.template bottomRows<3>();
  pose.force_jacobian = R_WB_ * (force_by_joint * C).eval();
  return true;
}

template <typename S>
Matrix3<S> Mechanism<S>::rotation(const AxisVector<S>& axes) const noexcept {
  const AxisVector<S> q = joints(axes);
  ChainPose<S> pose;
  chain_pose<S>(geometry_->chain, q.tail(geometry_->chain.count), pose);
  return R_WB_ * pose.rotation;
}

template <typename S>
void Mechanism<S>::clear_undriven(AxisVector<S>& torques) const noexcept {
  for (int i = 0; i < axes_; ++i)
    if (!geometry_->driven[static_cast<std::size_t>(i)]) torques[i] = 0;
}

template <typename S>
AxisVector<S> Mechanism<S>::torques(const MechanismPose<S>& pose, const Vector3<S>& force_N) const noexcept {
  AxisVector<S> torques = pose.force_jacobian.transpose() * force_N;
  clear_undriven(torques);
  return torques;
}

template <typename S>
AxisVector<S> Mechanism<S>::torques_of_wrench(const MechanismPose<S>& pose,
                                              const Eigen::Matrix<S, 6, 1>& wrench) const noexcept {
  AxisVector<S> torques = pose.jacobian.transpose() * wrench;
  clear_undriven(torques);
  return torques;
}

template class Mechanism<float>;
template class Mechanism<double>;

}  // namespace thimble::kinematics
