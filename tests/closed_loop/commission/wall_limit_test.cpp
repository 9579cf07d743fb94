// The stiffest wall that the tool computes from an arm's file, against that of the firmware on the simulated arm of docs/stability.md.
#include "host-tools/commission/wall_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "host-tools/arms/arm_data.h"
#include "host-tools/commission/wall_loop.h"
#include "host-tools/sweep/wall_press.h"
#include "tests/support/figure.h"

namespace thimble::host {
namespace {

ArmFile wall_arm(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

using Swing = std::function<double(double)>;  // of a wall, by its stiffness, as a part of what is a swing

Swing swing_with_firmware(const kinematics::ArmData& data, double most_m, const WallTrial& trial) {
  return [=](double k) {
    const Measured seen = measure(WallPress{.arm_data = data,
                                            .rate_Hz = trial.rate_Hz,
                                            .stiffness_N_m = k,
                                            .damping_N_s_m = trial.damping_N_s_m,
                                            .hold_s = trial.hold_s,
                                            .hand = trial.hand});
    return seen.is_ok() ? seen.tip_swing_m / most_m : std::numeric_limits<double>::infinity();
  };
}

// Of five walls 3 % apart, as largest_still_N_m has it.
double median_swing(const Swing& swing, double k) {
  std::array<double, 5> near{};
  for (std::size_t i = 0; i < near.size(); ++i)
    near.at(i) = swing(k * std::pow(1.03, static_cast<double>(i) - 2));
  std::ranges::nth_element(near, near.begin() + 2);
  return near[2];
}

// Other arms and rates take minutes, and so does the firmware's own limit: only with THIMBLE_COMMISSION_ARMS. Otherwise a wall at each end of the 15 %.
bool is_long() { return std::getenv("THIMBLE_COMMISSION_ARMS") != nullptr; }

class WallLimitOf : public testing::TestWithParam<std::string> {};

TEST_P(WallLimitOf, IsThatOfTheFirmwareOnTheSimulatedArm) {
  const ArmFile file = wall_arm(GetParam());
  const board::AnyPlantParameters plant = board::AnyPlantParameters::from(arm_data(file));
  for (const double rate_Hz : {1000, 4000, 10000}) {
    if (rate_Hz > 1000 && !is_long()) break;
    const WallTrial trial{.rate_Hz = rate_Hz, .damping_N_s_m = 1};
    const double computed = largest_wall_N_m(file, plant, trial);
    test::figure(GetParam() + " at " + std::to_string(static_cast<int>(rate_Hz)) + " Hz, N/m: computed",
                 computed, "15 %");
    const Swing swing = swing_with_firmware(arm_data(file), wall_tolerance_m(file), trial);
    if (!is_long()) {
      EXPECT_LE(median_swing(swing, computed * .85), 1) << GetParam();
      EXPECT_GT(median_swing(swing, computed * 1.15), 1) << GetParam();
      continue;
    }
    const double found = largest_still_N_m(swing);
    test::figure("  firmware", found, "");
    EXPECT_NEAR(computed / found, 1, .15) << GetParam() << " at " << rate_Hz;
  }
}

// Not touch: its 3.3 N are what a count gives on a wall of 20 kN/m, its force goes to and fro there, and its swing, near two counts over a wide range of
// walls, tells no limit. Computed it is a fifth lower than of the firmware at 4 and 10 kHz, and at 1 kHz the firmware has none.
std::vector<std::string> arms() {
  return is_long() ? std::vector<std::string>{"premium-1.5", "wooden", "falcon"}
                   : std::vector<std::string>{"premium-1.5"};
}
INSTANTIATE_TEST_SUITE_P(Arms, WallLimitOf, testing::ValuesIn(arms()),
                         [](const auto& arm) { return arm.param.substr(0, arm.param.find('-')); });

// The other joints of a redundant arm keep their torques while one is probed: no force at the tip asks for that (drive.cpp).
TEST(WallLoop, AProbeTakesTheTorqueFromTheJointItself) {
  const ArmFile file = wall_arm("chain-7");
  const Expectation arm(file);
  TipProgram wall;
  wall.kind = TipProgram::Kind::kWall;
  wall.wall_normal = wall_normal(arm);
  wall.stiffness_N_m = 1e4;
  wall.most_force_N = 100;
  WallLoop loop(arm, wall, 1e-3);
  PerAxis<std::int64_t> counts{};
  static_cast<void>(loop.currents(arm.home(), counts));
  board::JointVector in_it = arm.home();
  const board::JointVector down = -arm.jacobian(in_it).transpose() * wall.wall_normal;
  in_it += .01 / down.squaredNorm() * down;  // 10 mm deep
  Eigen::Index moves = 0;                    // this joint counts, the others do not
  down.cwiseAbs().maxCoeff(&moves);
  std::vector<board::JointVector> asked;
  for (int k = 0; k < 600; ++k) {
    counts.at(static_cast<std::size_t>(moves)) = k % 20 < 10 ? 3 : 0;
    asked.push_back(loop.currents(in_it, counts));
  }
  const board::JointVector whole = asked[40], probed = asked.back(), weight = arm.weight(in_it);
  int taken = 0;
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    const double per_ampere = arm.axis(j).per_ampere(), push = whole[row] * per_ampere - weight[row];
    const double left = probed[row] * per_ampere - weight[row];
    const bool is_probed = std::abs(left) < 1e-3 * std::abs(push);
    taken += is_probed && std::abs(push) > .1 ? 1 : 0;
    if (!is_probed) {
      EXPECT_NEAR(left, push, 1e-3 * std::abs(push)) << j;
    }
  }
  EXPECT_GE(taken, 1);
  EXPECT_GT(std::abs(probed[moves] * arm.axis(static_cast<std::size_t>(moves)).per_ampere() - weight[moves]),
            .1);
}

// At 4 kHz the limit cycle of a stiff wall would swing the tip by 0.9 mm. The firmware's force falls at once, and gives no energy that the
// hand has not paid: the tip swings by less than two counts.
TEST(WallLimit, HasTheLimitsOfTheFirmwaresForce) {
  const ArmFile file = wall_arm("premium-1.5");
  const WallTrial trial{.rate_Hz = 4000, .hold_s = 1};
  constexpr double kStiff_N_m = 18000;
  const double computed_m =
      wall_swing_m(file, board::AnyPlantParameters::from(arm_data(file)), kStiff_N_m, trial);
  const Measured seen = measure(WallPress{
      .arm_data = arm_data(file), .stiffness_N_m = kStiff_N_m, .damping_N_s_m = 0, .hold_s = trial.hold_s});
  ASSERT_TRUE(seen.is_ok());
  test::figure("swing of the tip on 18000 N/m at 4 kHz, um: firmware", 1e6 * seen.tip_swing_m, "");
  test::figure("  computed", 1e6 * computed_m, "59, two counts");
  EXPECT_GT(seen.force_swing_N, 5) << "no limit cycle";
  EXPECT_LT(seen.tip_swing_m, wall_tolerance_m(file));
  EXPECT_LT(computed_m, wall_tolerance_m(file));
}

}  // namespace
}  // namespace thimble::host
