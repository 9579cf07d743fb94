// What is measured, against closed forms: in an ideal run a floor is a spring.
#include "host-tools/sweep/measures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host-tools/compiler/compile.h"
#include "host-tools/sweep/wall_press.h"
#include "tests/support/figure.h"
#include "tests/unit/sweep/plans.h"

namespace thimble::test {
namespace {

using host::Measured;
using host::MeasuredRun;

constexpr double kDeep_m = .002, kStiff_N_m = 1000;

MeasuredRun ideal_press() {
  MeasuredRun run;
  run.image = host::compile_scene_text(kFloorScene, "floor", {}).image;
  run.path = {{0, {0, 0, .001}}, {.03, {0, 0, -kDeep_m}}, {.13, {0, 0, -kDeep_m}}, {.16, {0, 0, .001}}};
  run.options.ideal = true;
  return run;
}

TEST(SweepMeasures, ASpringGivesWhatItTook) {
  const Measured whole = host::measure(ideal_press());
  ASSERT_TRUE(whole.is_ok()) << whole.detail;
  EXPECT_NEAR(whole.peak_force_N, kStiff_N_m * kDeep_m, 1e-4);
  EXPECT_NEAR(whole.work_J, 0, 1e-7);
  EXPECT_EQ(whole.contacts_lost, 1);
  EXPECT_NEAR(whole.contact_s, .14, 2.0 / 4000) << "two thirds of each way, and the hold";
  // The mean over both ways is half of the peak.
  EXPECT_NEAR(whole.mean_force_N, (.1 + .04 / 2) / .14 * kStiff_N_m * kDeep_m, .01);
  MeasuredRun in = ideal_press();
  in.path.pop_back();
  const Measured half = host::measure(in);
  figure("work of a press, J", half.work_J, "-K d^2 / 2 = -0.002");
  EXPECT_NEAR(half.work_J, -kStiff_N_m * kDeep_m * kDeep_m / 2, 1e-6);
  EXPECT_EQ(half.contacts_lost, 0);
}

TEST(SweepMeasures, TheSteadyPartAlone) {
  MeasuredRun run = ideal_press();
  run.path.pop_back();
  run.steady_from_s = .05;
  const Measured still = host::measure(run);
  EXPECT_NEAR(still.steady_force_N, kStiff_N_m * kDeep_m, 1e-4);
  EXPECT_NEAR(still.tip_swing_m, 0, 1e-12);
  EXPECT_NEAR(still.force_swing_N, 0, 1e-6);
  EXPECT_TRUE(still.is_still());
  // A triangle of 2 A along x, for one period: the swing is 2 A, the speed 4 A / T, and none along z.
  constexpr double kSwing_m = .004, kPeriod_s = .1;
  run.path = {{0, {0, 0, -kDeep_m}},
              {kPeriod_s / 4, {kSwing_m / 2, 0, -kDeep_m}},
              {3 * kPeriod_s / 4, {-kSwing_m / 2, 0, -kDeep_m}},
              {kPeriod_s, {0, 0, -kDeep_m}}};
  run.steady_from_s = 0;
  const Measured swings = host::measure(run);
  EXPECT_NEAR(swings.tip_swing_m, kSwing_m, 1e-9);
  EXPECT_NEAR(swings.tip_speed_rms_m_s, 2 * kSwing_m / kPeriod_s, 1e-6);
  EXPECT_FALSE(swings.is_still());
  run.along = Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(host::measure(run).tip_swing_m, 0, 1e-12);
  run.along = Eigen::Vector3d(1, 1, 0).normalized();
  EXPECT_NEAR(host::measure(run).tip_swing_m, kSwing_m / std::sqrt(2), 1e-9);
}

TEST(SweepMeasures, AFaultIsNotStill) {
  MeasuredRun run = ideal_press();
  run.options.ideal = false;
  run.options.hand = {.05, 20000, 20};
  run.path = {{0, {0, 0, .01}}, {.004, {0, 0, -.02}}, {.1, {0, 0, -.02}}};  // 7.5 m/s
  const Measured measured = host::measure(run);
  EXPECT_EQ(measured.status, board::SimulationStatus::kFaulted) << measured.detail;
  EXPECT_FALSE(measured.is_still(1));
}

TEST(SweepMeasures, AHandSettlesAtTheForceOfItsPress) {
  for (const double force_N : {1.0, 3.0}) {
    const Measured press =
        host::measure(host::WallPress{.arm = "premium-1.5-frictionless", .force_N = force_N});
    ASSERT_TRUE(press.is_ok());
    figure("force of a press, N", press.steady_force_N, std::to_string(force_N) + ", a fiftieth");
    EXPECT_NEAR(press.steady_force_N, force_N, force_N / 50);
    EXPECT_TRUE(press.is_still());
  }
  EXPECT_THROW(static_cast<void>(host::measure(host::WallPress{.arm = "none"})), std::runtime_error);
}

}  // namespace
}  // namespace thimble::test
