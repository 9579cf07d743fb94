#include "host-tools/commission/wall_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "host-tools/commission/wall_loop.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

constexpr double kWall_m = .01;     // from home along the normal
constexpr double kMostForce_N = 8;  // the firmware clamps to this, or to the limit of the arm
constexpr double kSoftest_N_m = 100, kRise = 1.03;
constexpr int kLast = 233;  // 98 kN/m; a scene may have 100
constexpr int kFar = 12, kBack = 6;
constexpr double kNear = .5;  // of a swing
constexpr int kBeside = 2;

using Registers = std::array<std::uint32_t, kinematics::kMaxJoints>;

// The registers have the widths of the encoders.
PerAxis<std::int64_t> since(const ArmFile& file, const Registers& zero, const Registers& now) {
  PerAxis<std::int64_t> moved{};
  for (std::size_t j = 0; j < file.axes.size(); ++j) {
    const auto bits = static_cast<unsigned>(file.axes[j].encoder.counter_bits);
    const std::uint32_t raw = (now.at(j) - zero.at(j)) << (32U - bits);
    moved.at(j) = static_cast<std::int32_t>(raw) / (1 << (32U - bits));
  }
  return moved;
}

}  // namespace

double wall_tolerance_m(const ArmFile& file) { return wall_tolerance_m(Expectation(file)); }

double wall_swing_m(const ArmFile& file, const board::AnyPlantParameters& parameters, double stiffness_N_m,
                    const WallTrial& trial) {
  const Expectation arm(file);
  TipProgram wall;
  wall.kind = TipProgram::Kind::kWall;
  wall.stiffness_N_m = stiffness_N_m;
  wall.damping_N_s_m = trial.damping_N_s_m;
  wall.most_force_N = std::min(kMostForce_N, file.max_force_N);
  wall.wall_normal = wall_normal(arm);
  wall.wall_depth_m = kWall_m;
  WallLoop loop(arm, wall, 1 / trial.rate_Hz);
  board::AnyPlant plant(parameters, trial.hand);
  const Registers zero = plant.encoder_counts();
  const Vector3d start_m = plant.force_point_m();
  // At rest the wall, the arm's structure and the hand are three springs in a row.
  const double way_m = kWall_m + trial.force_N / stiffness_N_m + trial.force_N / file.tip_stiffness_N_m +
                       trial.force_N / trial.hand.stiffness_N_m;
  const double travel_s = way_m / trial.approach_m_s, tick_s = 1 / trial.rate_Hz;
  double low_m = 1e9, high_m = -1e9;
  for (double t = 0; t < travel_s + trial.hold_s; t += tick_s) {
    const double part = std::min(1.0, t / travel_s);
    plant.set_hand_target(start_m - part * way_m * wall.wall_normal,
                          part < 1 ? Vector3d(-trial.approach_m_s * wall.wall_normal) : Vector3d::Zero());
    const PerAxis<std::int64_t> counts = since(file, zero, plant.encoder_counts());
    JointVector at = arm.home();
    for (std::size_t j = 0; j < arm.axes(); ++j)
      at[static_cast<Eigen::Index>(j)] += static_cast<double>(counts.at(j)) * file.axes[j].per_count();
    plant.command_current(loop.currents(at, counts), true);
    plant.step(tick_s);
    if (t < travel_s + trial.hold_s / 2) continue;
    const double height_m =
        trial.by_counts ? arm.tip_m(at).dot(wall.wall_normal) : plant.force_point_m().dot(wall.wall_normal);
    low_m = std::min(low_m, height_m);
    high_m = std::max(high_m, height_m);
    if (!(high_m - low_m < .05)) return 1;  // it swings away
  }
  return high_m - low_m;
}

double largest_still_N_m(const std::function<double(double)>& swing) {
  const auto stiffness_N_m = [](int wall) { return kSoftest_N_m * std::pow(kRise, wall); };
  std::map<int, double> seen;
  const auto swing_of = [&](int wall) {
    const auto [at, is_new] = seen.try_emplace(wall);
    if (is_new) at->second = swing(stiffness_N_m(wall));
    return at->second;
  };
  const auto swings = [&](int wall) {
    std::array<double, 2 * kBeside + 1> near{};
    for (int k = -kBeside; k <= kBeside; ++k)
      near.at(static_cast<std::size_t>(k + kBeside)) = swing_of(std::clamp(wall + k, 0, kLast));
    std::nth_element(near.begin(), near.begin() + kBeside, near.end());
    return near.at(kBeside) > 1;
  };
  int wall = 0;
  while (wall < kLast && swing_of(wall) <= kNear) wall = std::min(kLast, wall + kFar);
  for (wall = std::max(0, wall - kFar - kBack); wall <= kLast; ++wall)
    if (swings(wall)) return wall == 0 ? 0 : stiffness_N_m(wall - 1);
  return stiffness_N_m(kLast);
}

double largest_wall_N_m(const ArmFile& file, const board::AnyPlantParameters& plant, const WallTrial& trial) {
  const Expectation arm(file);
  const double most_m = trial.by_counts ? counted_tolerance_m(arm) : wall_tolerance_m(arm);
  return largest_still_N_m([&](double k) { return wall_swing_m(file, plant, k, trial) / most_m; });
}

}  // namespace thimble::host
