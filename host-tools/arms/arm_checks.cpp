#include "host-tools/arms/arm_checks.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>
#include <variant>

#include "kinematics/mechanism.h"

namespace thimble::host {
namespace {

// What the tip can do is judged to a thousandth of its best direction.
constexpr double kNoDirection = 1e-3;
constexpr double kMostCondition = 20;
constexpr double kCoarse_m = 2e-4;
constexpr double kNoLever_m = 1e-6;   // an axis through the point at which the force acts pushes nothing
constexpr double kFewestCounts = 16;  // between the limits of an axis

[[noreturn]] void refuse(const std::string& file, const char* slug, const std::string& cause,
                         const char* remedy) {
  throw Error(ExitCode::kBadInput, slug, file + ": " + cause, remedy);
}

void check_limits(const ArmFile& arm, const std::string& file) {
  const auto inside = [](double value, const Quantity& lower, const Quantity& upper) {
    return value >= lower.value && value <= upper.value;
  };
  for (const ArmAxis& axis : arm.axes) {
    if (!(axis.lower.value < axis.upper.value))
      refuse(file, "empty-range", "axis " + axis.name + " has a lower limit that is not below the upper one",
             "exchange them, or give it room to move");
    if (!inside(axis.home.value, axis.lower, axis.upper))
      refuse(file, "home-beyond-limits", "axis " + axis.name + " is at home beyond its limits",
             "give a home between them");
  }
  for (std::size_t i = 0; i < arm.limit_sums.size(); ++i) {
    const ArmLimitSum& sum = arm.limit_sums[i];
    if (!(sum.lower_rad.value < sum.upper_rad.value))
      refuse(file, "empty-range",
             fmt::format("limit_sums/{} has a lower limit that is not below the upper one", i),
             "exchange them, or give it room to move");
    double home = 0;
    for (std::size_t j = 0; j < arm.axes.size(); ++j) home += sum.weights[j] * arm.axes[j].home.value;
    if (!inside(home, sum.lower_rad, sum.upper_rad))
      refuse(file, "home-beyond-limits", fmt::format("home is beyond limit_sums/{}", i),
             "give a home between its limits");
  }
}

void check_electronics(const ArmFile& arm, const std::string& file) {
  std::set<int> encoders, drives;
  for (const ArmAxis& axis : arm.axes) {
    if (!encoders.insert(axis.encoder.port).second)
      refuse(file, "repeated-port", fmt::format("two encoders are on port {}", axis.encoder.port),
             "give each encoder a port of its own");
    if (axis.drive && !drives.insert(axis.drive->port).second)
      refuse(file, "repeated-port", fmt::format("two drives are on port {}", axis.drive->port),
             "give each drive a port of its own");
    const double counts_per_rad = 1.0 / std::abs(axis.per_count());
    const double counts = counts_per_rad * (axis.upper.value - axis.lower.value);
    if (counts < kFewestCounts)
      refuse(file, "too-few-counts",
             fmt::format("axis {} counts {:.2g} between its limits, and {:.0f} are the least", axis.name,
                         counts, kFewestCounts),
             "correct counts_per_turn, turns_per_turn or the limits");
    if (counts >= std::exp2(axis.encoder.counter_bits - 1))
      refuse(file, "counter-wraps",
             fmt::format(
                 "axis {} counts {:.0f} between its limits, and half of its counter of {} bits is {:.0f}",
                 axis.name, counts, axis.encoder.counter_bits, std::exp2(axis.encoder.counter_bits - 1)),
             "use a wider counter, or fewer counts");
    const double rate_Hz = counts_per_rad * arm.max_joint_speed_rad_s;
    if (!axis.is_prismatic && axis.encoder.max_rate_Hz > 0 && rate_Hz > axis.encoder.max_rate_Hz)
      refuse(
          file, "encoder-rate",
          fmt::format("axis {} counts {:.0f} a second at max_joint_speed_rad_s, its encoder's input {:.0f}",
                      axis.name, rate_Hz, axis.encoder.max_rate_Hz),
          "lower max_joint_speed_rad_s, or use a faster input");
  }
  if (drives.empty())
    refuse(file, "no-drive", "no axis has a drive, so there is no force", "add the drives of the motors");
}

// The least and the greatest force over directions that can be felt, with every motor at its peak at most.
void find_peak_forces(const ArmFile& arm, const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& directions,
                      ArmFigures& figures) {
  constexpr int kSteps = 64;
  figures.least_peak_force_N = HUGE_VAL;
  const auto look = [&](const Eigen::Vector3d& direction) {
    const Eigen::VectorXd torque = jacobian.transpose() * direction;
    double force_N = HUGE_VAL;
    for (std::size_t j = 0; j < arm.axes.size(); ++j) {
      const double needed = std::abs(torque[static_cast<Eigen::Index>(j)]);
      if (arm.axes[j].drive && needed > 0) force_N = std::min(force_N, arm.axes[j].peak_torque() / needed);
    }
    figures.least_peak_force_N = std::min(figures.least_peak_force_N, force_N);
    figures.most_peak_force_N = std::max(figures.most_peak_force_N, force_N);
  };
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j <= (figures.force_dof == 3 ? kSteps / 2 : 0); ++j) {
      const double lon = 2 * M_PI * i / kSteps,
                   lat = figures.force_dof == 3 ? M_PI * (2.0 * j / kSteps - 0.5) : 0;
      const Eigen::Vector3d along(std::cos(lon) * std::cos(lat), std::sin(lon) * std::cos(lat),
                                  std::sin(lat));
      const Eigen::VectorXd parts = along.head(figures.force_dof);
      if (parts.norm() > 0.1) look((directions.leftCols(figures.force_dof) * parts).normalized());
    }
  }
}

int rank(const Eigen::VectorXd& singular_values) {
  return static_cast<int>((singular_values.array() > kNoDirection * singular_values[0]).count());
}

// A delta's joints have two places for the plate, and home_axis_m says where to look: is the one that was found that of `branch`?
void check_branch(const kinematics::Mechanism<double>& mechanism, const Eigen::Vector3d& plate_m,
                  const std::string& file) {
  const auto* delta = std::get_if<kinematics::DeltaGeometry>(&mechanism.geometry().platform);
  if (delta == nullptr) return;
  const Eigen::Vector3d q = mechanism.joints(mechanism.home()).head<3>();
  Eigen::Vector3d of_branch = Eigen::Vector3d::Constant(HUGE_VAL);
  static_cast<void>(kinematics::Delta<double>(*delta).inverse(plate_m, of_branch));
  if (!((of_branch - q).array().cos() > 1 - 1e-9).all())
    refuse(file, "wrong-branch",
           fmt::format("with all axes at home the plate is at a height of {:.4f} m, where branch has other "
                       "angles of the axes",
                       plate_m.z()),
           "correct home_axis_m, or else branch");
}

// Ranks of the driven Jacobian of the force point, and of that of the tip, with its angles.
struct Ranks {
  int force = 0, pose = 0;
};
Eigen::MatrixXd driven_of(const ArmFile& arm, const kinematics::MechanismPose<double>& pose) {
  Eigen::MatrixXd driven = pose.force_jacobian;
  for (Eigen::Index j = 0; j < driven.cols(); ++j)
    if (!arm.geometry.driven[static_cast<std::size_t>(j)]) driven.col(j).setZero();
  return driven;
}
Ranks ranks_of(const ArmFile& arm, const kinematics::MechanismPose<double>& pose) {
  // Metres and radians: what turns the tip by one radian is taken for what moves it by 0.1 m.
  Eigen::MatrixXd twist = pose.jacobian;
  twist.bottomRows(3) *= 0.1;
  return {rank(Eigen::JacobiSVD<Eigen::MatrixXd>(driven_of(arm, pose)).singularValues()),
          rank(Eigen::JacobiSVD<Eigen::MatrixXd>(twist).singularValues())};
}

// The greatest of home and of places around it, each axis moved by a tenth of its range and all at once: at home itself a direction may be lost.
Ranks ranks_around_home(const ArmFile& arm, const kinematics::Mechanism<double>& mechanism) {
  const kinematics::MechanismPose<double> home = mechanism.home_pose();
  Ranks most = ranks_of(arm, home);
  for (int moved = 0; moved <= mechanism.axes(); ++moved) {
    for (const double way : {-0.1, 0.1}) {
      kinematics::AxisVector<double> axes = mechanism.home();
      for (int j = 0; j < mechanism.axes(); ++j) {
        const ArmAxis& axis = arm.axes[static_cast<std::size_t>(j)];
        if (moved == j || moved == mechanism.axes())
          axes[j] = std::clamp(axes[j] + way * (axis.upper.value - axis.lower.value), axis.lower.value,
                               axis.upper.value);
      }
      kinematics::MechanismPose<double> pose = home;
      if (!mechanism.at(axes, pose)) continue;
      const Ranks here = ranks_of(arm, pose);
      most = {std::max(most.force, here.force), std::max(most.pose, here.pose)};
    }
  }
  return most;
}

ArmFigures figures_of(const ArmFile& arm, const std::string& file) {
  const kinematics::Mechanism<double> mechanism(arm.geometry);
  kinematics::MechanismPose<double> pose = mechanism.home_pose();
  if (!mechanism.closes_at_home() || !pose.jacobian.allFinite())
    refuse(file, "does-not-close",
           "the links do not meet with all axes at home, or so near to a singularity that no force is safe",
           "check the lengths, the coupling and the angles of home");
  check_branch(mechanism, pose.plate_m, file);
  ArmFigures figures;
  figures.home_tip_m = arm.geometry.rotation.cast<double>() * (pose.plate_m + pose.chain.tip_m);
  const Eigen::MatrixXd driven = driven_of(arm, pose);
  const Eigen::JacobiSVD<Eigen::MatrixXd> felt(driven, Eigen::ComputeThinU);
  if (!(felt.singularValues()[0] > 0))
    refuse(file, "no-force", "no motor moves the point where the force acts",
           "check which axes have drives, and force_at");
  figures.force_dof = rank(felt.singularValues());
  const Ranks around = ranks_around_home(arm, mechanism);
  if (figures.force_dof < around.force)
    refuse(file, "singular-home",
           fmt::format("at home a force is felt in {} directions, near it in {}", figures.force_dof,
                       around.force),
           "put home in the middle of the workspace");
  figures.pose_dof = around.pose;
  for (int i = 0; i < figures.force_dof; ++i) figures.singular_values.push_back(felt.singularValues()[i]);
  find_peak_forces(arm, driven, felt.matrixU(), figures);
  for (std::size_t j = 0; j < arm.axes.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    const double lever = driven.col(column).norm();
    figures.axes.push_back({std::abs(arm.axes[j].per_count()) * pose.jacobian.col(column).head<3>().norm(),
                            lever > kNoLever_m ? arm.axes[j].peak_torque() / lever : 0.0});
  }
  return figures;
}

}  // namespace

ArmFigures check_arm(const ArmFile& arm, const std::string& file) {
  check_limits(arm, file);
  check_electronics(arm, file);
  ArmFigures figures = figures_of(arm, file);
  const double condition = figures.singular_values.front() / figures.singular_values.back();
  if (condition > kMostCondition)
    refuse(file, "singular-home",
           fmt::format(
               "at home the tip moves {:.0f} times as far in one direction as in another, {:.0f} is allowed",
               condition, kMostCondition),
           "put home in the middle of the workspace");
  if (figures.least_peak_force_N < 0.5 * arm.max_force_N)
    figures.warnings.push_back(fmt::format(
        "at home the motors give {:.2f} N in the weakest direction, less than half of max_force_N, {:.2f} N",
        figures.least_peak_force_N, arm.max_force_N));
  for (std::size_t j = 0; j < arm.axes.size(); ++j)
    if (arm.axes[j].drive && figures.axes[j].count_m > kCoarse_m)
      figures.warnings.push_back(
          fmt::format("one count of axis {} is {:.2f} mm at the tip: walls will feel rough", arm.axes[j].name,
                      1e3 * figures.axes[j].count_m));
  if (arm.changed_since())
    figures.warnings.push_back(fmt::format(
        "it was changed since it passed `thimble commission` on {}: a device refuses to arm it with a "
        "max_force above 1 N until it has passed again",
        arm.commissioned_on));
  return figures;
}

}  // namespace thimble::host
