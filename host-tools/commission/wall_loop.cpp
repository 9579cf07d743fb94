#include "host-tools/commission/wall_loop.h"

#include <algorithm>
#include <cmath>

#include "firmware/params.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using firmware::Param;

float initial(Param param) { return firmware::row_of(param).initial; }

}  // namespace

Vector3d wall_normal(const Expectation& arm) {
  const board::ByJoint J = arm.jacobian(arm.home());
  if (J.row(2).norm() > .5 * J.colwise().norm().maxCoeff()) return Vector3d::UnitZ();
  Eigen::Index longest = 0;
  static_cast<void>(J.colwise().norm().maxCoeff(&longest));
  return J.col(longest).normalized();
}

double wall_tolerance_m(const Expectation& arm) {
  const board::ByJoint J = arm.jacobian(arm.home());
  const Vector3d normal = wall_normal(arm);
  double count_m = 0;
  for (std::size_t j = 0; j < arm.axes(); ++j)
    count_m = std::max(count_m,
                       std::abs(arm.axis(j).per_count() * normal.dot(J.col(static_cast<Eigen::Index>(j)))));
  return 2 * count_m;
}

WallLoop::WallLoop(const Expectation& arm, const TipProgram& wall, double tick_s)
    : arm_(arm),
      mechanism_(arm.arm().geometry),
      pose_(mechanism_.home_pose()),
      wall_(wall),
      tick_s_(tick_s),
      redundant_(std::ranges::count_if(arm.arm().axes,
                                       [](const ArmAxis& axis) { return axis.drive.has_value(); }) > 3),
      estimators_(arm.axes(), kinematics::VelocityEstimator(static_cast<float>(tick_s))),
      torque_(JointVector::Zero(static_cast<Eigen::Index>(arm.axes()))),
      watches_(arm.axes()) {}

JointVector WallLoop::currents(const JointVector& at, const PerAxis<std::int64_t>& counts) {
  const Eigen::Index n = at.size();
  JointVector speed = JointVector::Zero(n), current = JointVector::Zero(n);
  if (!begun_) {
    first_ = counts;
    for (kinematics::VelocityEstimator& estimator : estimators_) estimator.reset(0);
  }
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto axis = static_cast<std::size_t>(j);
    moved_.at(axis) = static_cast<std::int32_t>(counts.at(axis) - first_.at(axis));
    speed[j] = static_cast<double>(estimators_[axis].update(moved_.at(axis))) * arm_.axis(axis).per_count();
  }
  if (!mechanism_.at(at, pose_)) return current;
  const double height_m = pose_.force_point_m.dot(wall_.wall_normal);
  if (!begun_) home_m_ = height_m;
  begun_ = true;
  const Vector3d velocity = pose_.force_jacobian * speed;
  tip_speed_m_s_ = velocity.norm();
  const double depth_m = home_m_ - wall_.wall_depth_m - height_m;
  double wanted_N = 0;
  if (depth_m > 0) {
    const double push_N = wall_.stiffness_N_m * depth_m;
    wanted_N = push_N + std::max(-wall_.damping_N_s_m * velocity.dot(wall_.wall_normal), -push_N);
  }
  limit(wanted_N, std::max(0.0, depth_m));
  torque_ = torques() + arm_.weight(at);
  for (Eigen::Index j = 0; j < n; ++j) {
    const ArmAxis& axis = arm_.axis(static_cast<std::size_t>(j));
    if (axis.drive) current[j] = torque_[j] / axis.per_ampere();
  }
  return current;
}

// As find_torques() of firmware/core does: no force asks the joints of a redundant arm for what a probe leaves.
JointVector WallLoop::torques() const {
  const bool by_joint = redundant_ && probe_.probes();
  JointVector torque = mechanism_.torques(pose_, (by_joint ? unprobed_N_ : force_N_).cast<double>());
  if (by_joint)
    for (std::size_t j = 0; j < arm_.axes(); ++j)
      torque[static_cast<Eigen::Index>(j)] *= static_cast<double>(probe_.part(j));
  return torque;
}

// As probed() of firmware/core does: what is left of the force while a joint is probed that may have a dead encoder. The board's receivers report a lost
// line, so standing still alone is no reason for a probe.
Eigen::Vector3f WallLoop::probed(const Eigen::Vector3f& wanted_N) {
  const auto tick_s = static_cast<float>(tick_s_);
  const bool probed_before = probe_.probes();
  JointVector torque = mechanism_.torques(pose_, unprobed_N_.cast<double>());
  const JointVector wanted = mechanism_.torques(pose_, wanted_N.cast<double>());
  for (std::size_t j = 0; j < arm_.axes(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    const ArmAxis& axis = arm_.axis(j);
    if (!axis.drive) continue;
    const auto count = static_cast<float>(std::abs(axis.per_count()));
    const float most_change = initial(Param::encoder_frozen) * static_cast<float>(axis.peak_torque());
    const auto lever2_m2 = static_cast<float>(pose_.force_jacobian.col(i).squaredNorm());
    const firmware::SureChange sure(firmware::EncoderProbe::kCounts,
                                    static_cast<float>(axis.friction.coulomb_N_m.value), count,
                                    firmware::EncoderProbe::kFirmHand_N_m);
    const double asked = probed_before && probe_.part(j) < 1 ? wanted[i] : torque[i];
    probe_.watch(j,
                 {.counts = moved_.at(j),
                  .pushes_up = torque[i] * axis.per_count() > 0,
                  .holds = std::abs(asked) > static_cast<double>(sure.torque_N_m(lever2_m2)),
                  .changed = watches_[j].frozen(moved_.at(j), static_cast<float>(torque_[i]), most_change,
                                                initial(Param::encoder_frozen_time), tick_s),
                  .may_rest = true},
                 tick_s);
    torque[i] *= static_cast<double>(probe_.part(j));
  }
  if (!probe_.probes()) return unprobed_N_;
  const Eigen::MatrixXd by_force = pose_.force_jacobian.transpose();
  const Vector3d left_N = by_force.completeOrthogonalDecomposition().solve(torque);
  return firmware::clamp_force(left_N.cast<float>(), unprobed_N_.norm()).value;
}

// As limit_forces() of firmware/core: clamped; rises no faster than the slew limit and falls at once; and gives no energy that the hand has not paid.
void WallLoop::limit(double wanted_N, double depth_m) {
  const auto tick_s = static_cast<float>(tick_s_);
  const Eigen::Vector3f tip_m = pose_.force_point_m.cast<float>();
  const Eigen::Vector3f push_N = (wanted_N * wall_.wall_normal).cast<float>();
  const auto wanted = static_cast<float>(wanted_N), depth = static_cast<float>(depth_m);
  const auto most = static_cast<float>(wall_.most_force_N);
  if (!limits_begun_) account_.start(most, tip_m);
  limits_begun_ = true;
  const float max_N = account_.max_N(most, wanted, depth, firmware::kLimitSlew_N_s * tick_s, tick_s);
  const Eigen::Vector3f clamped_N = firmware::clamp_force(push_N, max_N).value;
  const Eigen::Vector3f& last_N = probe_.probes() ? unprobed_N_ : force_N_;
  unprobed_N_ = firmware::slew_force(clamped_N, firmware::remaining(last_N, clamped_N),
                                     initial(Param::force_slew) * tick_s)
                    .value;
  if (const float paid = account_.paid(tip_m, clamped_N, tick_s); paid < 1.0F)
    unprobed_N_ = firmware::clamp_force(unprobed_N_, paid * std::min(wanted, max_N)).value;
  force_N_ = probed(clamped_N);
  account_.add(clamped_N, force_N_, std::min(wanted / 2, max_N) * depth);
}

}  // namespace thimble::host
