#include "host-tools/commission/wall_loop.h"

#include <algorithm>
#include <cmath>

namespace thimble::host {
namespace {

using Eigen::Vector3d;

constexpr float kSlew_N_s = 1e4F;  // force_slew of the firmware

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
      estimators_(arm.axes(), kinematics::VelocityEstimator(static_cast<float>(tick_s))) {}

JointVector WallLoop::currents(const JointVector& at, const PerAxis<std::int64_t>& counts) {
  const Eigen::Index n = at.size();
  JointVector speed = JointVector::Zero(n), current = JointVector::Zero(n);
  if (!begun_) {
    first_ = counts;
    for (kinematics::VelocityEstimator& estimator : estimators_) estimator.reset(0);
  }
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto axis = static_cast<std::size_t>(j);
    const auto moved = static_cast<std::int32_t>(counts.at(axis) - first_.at(axis));
    speed[j] = static_cast<double>(estimators_[axis].update(moved)) * arm_.axis(axis).per_count();
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
  const JointVector torque = mechanism_.torques(pose_, force_N_.cast<double>()) + arm_.weight(at);
  for (Eigen::Index j = 0; j < n; ++j) {
    const ArmAxis& axis = arm_.axis(static_cast<std::size_t>(j));
    if (axis.drive) current[j] = torque[j] / axis.per_ampere();
  }
  return current;
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
  Eigen::Vector3f limited_N =
      firmware::slew_force(clamped_N, firmware::remaining(force_N_, clamped_N), kSlew_N_s * tick_s).value;
  if (const float paid = account_.paid(tip_m, tick_s); paid < 1.0F)
    limited_N = firmware::clamp_force(limited_N, paid * std::min(wanted, max_N)).value;
  account_.add(clamped_N, limited_N, std::min(wanted / 2, max_N) * depth);
  force_N_ = limited_N;
}

}  // namespace thimble::host
