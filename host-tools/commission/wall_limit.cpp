#include "host-tools/commission/wall_limit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host-tools/commission/expectation.h"
#include "kinematics/mechanism.h"
#include "kinematics/velocity.h"

namespace thimble::host {
namespace {

using board::JointVector;
using Eigen::Vector3d;

constexpr double kWall_m = .01;     // from home along the normal
constexpr double kMostForce_N = 8;  // the firmware's clamp
constexpr double kSlew_N_s = 1e4;   // and its limit of the rate
constexpr double kSoftest_N_m = 100, kStiffest_N_m = 1e5, kFifth = 1.2;

// Down where the tip goes up and down, otherwise along the way of the axis that moves it most.
Vector3d wall_normal(const Expectation& arm) {
  const board::ByJoint J = arm.jacobian(arm.home());
  if (J.row(2).norm() > .5 * J.colwise().norm().maxCoeff()) return Vector3d::UnitZ();
  Eigen::Index longest = 0;
  static_cast<void>(J.colwise().norm().maxCoeff(&longest));
  return J.col(longest).normalized();
}

// The controller of one arm: counts to force to currents, as the firmware does it.
class WallLoop {
 public:
  WallLoop(const ArmFile& file, const Expectation& arm, double stiffness_N_m, const WallTrial& trial)
      : file_(file),
        arm_(arm),
        mechanism_(file.geometry),
        pose_(mechanism_.home_pose()),
        normal_(wall_normal(arm)),
        stiffness_N_m_(stiffness_N_m),
        trial_(trial),
        estimators_(file.axes.size(), kinematics::VelocityEstimator(static_cast<float>(1 / trial.rate_Hz))) {}

  [[nodiscard]] const Vector3d& normal() const { return normal_; }

  void begin(const std::array<std::uint32_t, kinematics::kMaxJoints>& counts) {
    zero_ = counts;
    for (kinematics::VelocityEstimator& estimator : estimators_) estimator.reset(0);
  }

  [[nodiscard]] JointVector currents(const std::array<std::uint32_t, kinematics::kMaxJoints>& counts) {
    const auto n = static_cast<Eigen::Index>(file_.axes.size());
    JointVector q = arm_.home(), qd = JointVector::Zero(n), current = JointVector::Zero(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const auto bits = static_cast<unsigned>(file_.axes[at].encoder.counter_bits);
      const std::uint32_t raw = (counts.at(at) - zero_.at(at)) << (32U - bits);
      const auto moved = static_cast<std::int32_t>(raw) / (1 << (32U - bits));
      q[j] += static_cast<double>(moved) * file_.axes[at].per_count();
      qd[j] = static_cast<double>(estimators_[at].update(moved)) * file_.axes[at].per_count();
    }
    if (!mechanism_.at(q, pose_)) return current;
    const double depth_m = -kWall_m - pose_.force_point_m.dot(normal_) + begin_m(q);
    const double speed = normal_.dot(pose_.force_jacobian * qd);
    double wanted_N = 0;
    if (depth_m > 0) {
      const double push_N = stiffness_N_m_ * depth_m;
      wanted_N = push_N + std::max(-trial_.damping_N_s_m * speed, -push_N);
    }
    wanted_N = std::min(wanted_N, kMostForce_N);
    const double step_N = kSlew_N_s / trial_.rate_Hz;
    force_N_ += std::clamp(wanted_N - force_N_, -step_N, step_N);
    const JointVector torque = mechanism_.torques(pose_, force_N_ * normal_) + arm_.weight(q);
    for (Eigen::Index j = 0; j < n; ++j) {
      const ArmAxis& axis = file_.axes[static_cast<std::size_t>(j)];
      if (axis.drive) current[j] = torque[j] / axis.per_ampere();
    }
    return current;
  }

 private:
  // The force point where the arm is at home: the wall is beside it.
  [[nodiscard]] double begin_m(const JointVector& /*q*/) {
    if (!begun_) {
      home_m_ = mechanism_.home_pose().force_point_m.dot(normal_);
      begun_ = true;
    }
    return home_m_;
  }

  const ArmFile& file_;
  const Expectation& arm_;
  kinematics::Mechanism<double> mechanism_;
  kinematics::MechanismPose<double> pose_;
  Vector3d normal_;
  double stiffness_N_m_;
  WallTrial trial_;
  std::vector<kinematics::VelocityEstimator> estimators_;
  std::array<std::uint32_t, kinematics::kMaxJoints> zero_{};
  double force_N_ = 0, home_m_ = 0;
  bool begun_ = false;
};

}  // namespace

double wall_tolerance_m(const ArmFile& file) {
  const Expectation arm(file);
  const board::ByJoint J = arm.jacobian(arm.home());
  const Vector3d normal = wall_normal(arm);
  double count_m = 0;
  for (std::size_t j = 0; j < file.axes.size(); ++j)
    count_m = std::max(count_m,
                       std::abs(file.axes[j].per_count() * normal.dot(J.col(static_cast<Eigen::Index>(j)))));
  return 2 * count_m;
}

double wall_swing_m(const ArmFile& file, const board::AnyPlantParameters& parameters, double stiffness_N_m,
                    const WallTrial& trial) {
  const Expectation arm(file);
  WallLoop loop(file, arm, stiffness_N_m, trial);
  board::AnyPlant plant(parameters, trial.hand);
  loop.begin(plant.encoder_counts());
  const Vector3d start_m = plant.tip_m();
  // At rest the wall, the arm's structure and the hand are three springs in a row.
  const double way_m = kWall_m + trial.force_N / stiffness_N_m + trial.force_N / file.tip_stiffness_N_m +
                       trial.force_N / trial.hand.stiffness_N_m;
  const double travel_s = way_m / trial.approach_m_s, tick_s = 1 / trial.rate_Hz;
  double low_m = 1e9, high_m = -1e9;
  for (double t = 0; t < travel_s + trial.hold_s; t += tick_s) {
    const double part = std::min(1.0, t / travel_s);
    plant.set_hand_target(start_m - part * way_m * loop.normal(),
                          part < 1 ? Vector3d(-trial.approach_m_s * loop.normal()) : Vector3d::Zero());
    plant.command_current(loop.currents(plant.encoder_counts()), true);
    plant.step(tick_s);
    if (t < travel_s + trial.hold_s / 2) continue;
    const double height_m = plant.tip_m().dot(loop.normal());
    low_m = std::min(low_m, height_m);
    high_m = std::max(high_m, height_m);
    if (!(high_m - low_m < .05)) return 1;  // it swings away
  }
  return high_m - low_m;
}

double largest_wall_N_m(const ArmFile& file, const board::AnyPlantParameters& plant, const WallTrial& trial) {
  const double most_m = wall_tolerance_m(file);
  double last = 0;
  for (double k = kSoftest_N_m; k <= kStiffest_N_m; k *= kFifth) {
    if (wall_swing_m(file, plant, k, trial) <= most_m) {
      last = k;
      continue;
    }
    if (last == 0) return 0;
    for (double high = k; high > 1.03 * last;) {
      const double middle = std::sqrt(last * high);
      (wall_swing_m(file, plant, middle, trial) <= most_m ? last : high) = middle;
    }
    return last;
  }
  return kStiffest_N_m;
}

}  // namespace thimble::host
