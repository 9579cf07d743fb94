// What the hand can be given: clamp, slew, ramp, current and thermal limits over the real renderer and a tip
// that jumps about.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <random>

#include "firmware/core/force_limits.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

void set_param(Bench& bench, const char* name, float value) {
  const firmware::ParamRow* row = firmware::find_param(name);
  ASSERT_EQ(bench.controller->write_param(row->id, std::bit_cast<std::uint32_t>(value)),
            firmware::ParamStatus::kOk)
      << name;
}

TEST(Limits, ClampAndSlewKeepDirection) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0.0F, 10.0F);
  float worst_angle = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 force(normal(random), normal(random), normal(random));
    const Vec3 last(normal(random), normal(random), normal(random));
    const float limit = std::abs(normal(random));
    const auto clamped = firmware::clamp_force(force, limit);
    EXPECT_EQ(clamped.which, force.norm() > limit);
    EXPECT_LE(clamped.value.norm(), limit * (1 + 1e-6F));
    if (limit > 1e-3F)
      worst_angle = std::max(worst_angle, force.normalized().cross(clamped.value.normalized()).norm());
    const auto slewed = firmware::slew_force(force, last, limit);
    EXPECT_LE((slewed.value - last).norm(), limit * (1 + 1e-5F) + 1e-5F);
    EXPECT_EQ(slewed.which, (force - last).norm() > limit);
  }
  std::printf("worst turn by the clamp: %.2g rad\n", static_cast<double>(worst_angle));
  EXPECT_LT(worst_angle, 1e-6F);
}

// Random jumps, as fast as the encoders believe, in and out of a stiff wall; the scene is swapped now and
// then.
TEST(Limits, ForceNeverExceedsClampSlewOrRamp) {
  float worst_clamp = 0, worst_slew = 0, worst_ramp = 0, worst_current = 0;
  std::uint64_t limited[4] = {};
  std::uint64_t ticks = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    Bench bench;
    const float max_N = 0.5F + 12.0F * unit(random);
    const float slew_N_s = 200.0F + 40000.0F * unit(random);
    set_param(bench, "max_force", max_N);
    set_param(bench, "force_slew", slew_N_s);
    bench.load(100.0F + 9000.0F * unit(random), -0.0002F, 20.0F * unit(random));
    bench.home();
    bench.arm();
    const float bound_N = std::min(max_N, bench.arms[0].model().max_force_N);
    const float peak_A = bench.arms[0].model().motor.peak_current_A;
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();
    Vec3 last_N = bench.shown().arm[0].force_N;
    float last_scale = 1.0F;
    float largest_rendered_N = 0;
    for (int i = 0; i < 4000; ++i, ++ticks) {
      const double step = unit(random) < 0.02F ? 0.0014 : 0.0002;
      tip += step *
             Eigen::Vector3f(unit(random) - 0.5F, unit(random) - 0.5F, unit(random) - 0.5F).cast<double>();
      tip = tip.cwiseMax(Eigen::Vector3d(-0.03, -0.03, -0.03)).cwiseMin(Eigen::Vector3d(0.03, 0.03, 0.01));
      bench.place(tip);
      if (i % 1500 == 1499) bench.load(100.0F + 9000.0F * unit(random), 0.01F * unit(random));
      bench.tick();
      ASSERT_EQ(bench.mode(), Mode::kArmed)
          << "seed " << seed << " fault " << static_cast<int>(bench.controller->fault());
      const auto& arm = bench.shown().arm[0];
      largest_rendered_N = std::max(largest_rendered_N, arm.rendered_N.norm());
      worst_clamp = std::max(worst_clamp, arm.force_N.norm() / bound_N);
      // The motors' limit scales the force after the slew limit; the step is checked where it did not.
      const bool scaled = (arm.limiters & (firmware::kLimitCurrent | firmware::kLimitThermal)) != 0;
      if (!scaled && last_scale == 1.0F)
        worst_slew = std::max(worst_slew, (arm.force_N - last_N).norm() / (slew_N_s * bench.config.period_s));
      if (i < 790)
        worst_ramp =
            std::max(worst_ramp, arm.force_N.norm() / (bench.shown().ramp * largest_rendered_N + 1e-6F));
      for (const float current_A : bench.outputs.arm[0].current_A)
        worst_current = std::max(worst_current, std::abs(current_A) / peak_A);
      last_N = arm.force_N;
      last_scale = scaled ? 0.0F : 1.0F;
      for (unsigned bit = 0; bit < 4; ++bit) limited[bit] += arm.limiters >> bit & 1U;
    }
  }
  std::printf("%llu ticks: force/clamp %.7f, step/slew %.7f, force/ramp %.7f, current/peak %.7f\n",
              static_cast<unsigned long long>(ticks), static_cast<double>(worst_clamp),
              static_cast<double>(worst_slew), static_cast<double>(worst_ramp),
              static_cast<double>(worst_current));
  std::printf("ticks limited by clamp %llu, slew %llu, current %llu, thermal %llu\n",
              static_cast<unsigned long long>(limited[0]), static_cast<unsigned long long>(limited[1]),
              static_cast<unsigned long long>(limited[2]), static_cast<unsigned long long>(limited[3]));
  EXPECT_LE(worst_clamp, 1 + 1e-6F);
  EXPECT_LE(worst_slew, 1 + 1e-4F);  // the difference of two forces of up to 8 N, in float
  EXPECT_LE(worst_ramp, 1 + 1e-5F);
  EXPECT_GT(worst_ramp, 0.5F) << "the ramp was hardly met";
  EXPECT_LE(worst_current, 1.0F);
  EXPECT_GT(limited[0], 0U);
  EXPECT_GT(limited[1], 0U);
  EXPECT_GT(limited[2], 0U);
}

TEST(Limits, ForceRampsUpOver200ms) {
  Bench bench;
  bench.load(1000.0F,
             0.004F);  // the tip, at home, is 4 mm inside: the god object starts there, so lift and press
  bench.home();
  bench.move({0, 0, 0.01}, 200);
  bench.arm();
  bench.move({0, 0, 0.001}, 200);  // 3 mm deep, 50 ms after arming
  float at_ms[5] = {};
  for (int i = 200; i < 900; ++i) {
    bench.tick();
    if (i == 399) at_ms[2] = bench.force_N();
    if (i == 599) at_ms[3] = bench.force_N();
    if (i == 850) at_ms[4] = bench.force_N();
  }
  std::printf("force at 100, 150, 213 ms: %.3f %.3f %.3f N of 3\n", static_cast<double>(at_ms[2]),
              static_cast<double>(at_ms[3]), static_cast<double>(at_ms[4]));
  EXPECT_NEAR(at_ms[2], 1.5F, 0.05F);
  EXPECT_NEAR(at_ms[3], 2.25F, 0.05F);
  EXPECT_NEAR(at_ms[4], 3.0F, 0.05F);
}

// Heat of a held press against the closed form of the two nodes, and derating that keeps the current's
// direction.
TEST(Thermal, FollowsTheTwoNodes) {
  const kinematics::MotorModel& motor = kinematics::find_arm_model("premium-1.5")->motor;
  firmware::MotorHeat heat;
  const float current_A = 0.8F, ambient_C = 25.0F, period_s = 1.0F / 4000;
  double winding = 0, housing = 0;  // the same equations in double, at a fifth of the step
  const double c_w = static_cast<double>(motor.winding_time_constant_s / motor.winding_to_housing_K_W);
  const double c_h = static_cast<double>(motor.housing_time_constant_s / motor.housing_to_ambient_K_W);
  for (int i = 0; i < 4000 * 300; ++i) heat.add(motor, current_A, ambient_C, period_s);
  for (int i = 0; i < 300 * 500; ++i) {
    const double power =
        static_cast<double>(current_A * current_A * motor.resistance_ohm) * (1 + 0.00393 * winding);
    const double flow = (winding - housing) / static_cast<double>(motor.winding_to_housing_K_W);
    winding += (power - flow) / c_w * 0.002;
    housing += (flow - housing / static_cast<double>(motor.housing_to_ambient_K_W)) / c_h * 0.002;
  }
  std::printf("after 300 s at %.1f A: model %.3f C, reference %.3f C\n", static_cast<double>(current_A),
              static_cast<double>(heat.winding_C(ambient_C)), 25 + winding);
  EXPECT_NEAR(heat.winding_C(ambient_C), 25 + winding, 0.05);
}

TEST(Thermal, DeratingKeepsDirectionAndTheLimit) {
  Bench bench;
  set_param(bench, "winding_limit", 60.0F);
  bench.load(4000.0F, 0.0F);
  bench.home();
  bench.move({0.01, 0, 0.005}, 200);
  bench.arm();
  bench.move({0.01, 0, -0.0018}, 200);
  bench.ticks(1000);
  const Vec3 first_A = bench.shown().arm[0].current_A;
  float hottest_C = 0, coolest_derated_N = 100;
  bool derated = false;
  for (int i = 0; i < 4000 * 120; ++i) {
    bench.tick();
    ASSERT_EQ(bench.mode(), Mode::kArmed);
    const auto& arm = bench.shown().arm[0];
    hottest_C = std::max(hottest_C, std::ranges::max(arm.winding_C));
    if ((arm.limiters & firmware::kLimitThermal) != 0) {
      derated = true;
      coolest_derated_N = std::min(coolest_derated_N, arm.force_N.norm());
    }
  }
  const Vec3 last_A = bench.shown().arm[0].current_A;
  const float turn = first_A.normalized().cross(last_A.normalized()).norm();
  std::printf("120 s at %.2f A: hottest %.1f C of 60, force fell to %.2f N, currents turned by %.2g rad\n",
              static_cast<double>(first_A.cwiseAbs().maxCoeff()), static_cast<double>(hottest_C),
              static_cast<double>(coolest_derated_N), static_cast<double>(turn));
  EXPECT_TRUE(derated);
  EXPECT_LT(hottest_C, 60.0F);
  EXPECT_GT(hottest_C, 45.0F);
  EXPECT_LT(last_A.norm(), 0.8F * first_A.norm());
  EXPECT_LT(turn, 2e-2F);  // the tremble of one count turns it a little
}

// A scene swap in contact: the force goes down and up again, and never further than the slew limit in a tick.
TEST(SceneSwap, FadesInContact) {
  Bench bench;
  bench.start();
  bench.move({0, 0, 0.002}, 100);
  bench.move({0, 0, -0.003}, 400);
  bench.ticks(1000);
  const float before_N = bench.force_N();
  bench.load(2000.0F, 0.0F);
  float largest_step_N = 0, lowest_N = before_N;
  Vec3 last_N = bench.shown().arm[0].force_N;
  int switch_tick = -1;
  for (int i = 0; i < 2000; ++i) {
    bench.tick();
    const Vec3 force_N = bench.shown().arm[0].force_N;
    largest_step_N = std::max(largest_step_N, (force_N - last_N).norm());
    lowest_N = std::min(lowest_N, force_N.norm());
    last_N = force_N;
    if (switch_tick < 0 && bench.shown().scene_sequence == 2) {
      switch_tick = i;
      EXPECT_LT(force_N.norm(), 0.03F);
    }
  }
  std::printf("before %.3f N, switched after %d ticks, lowest %.4f N, largest step %.4f N\n",
              static_cast<double>(before_N), switch_tick, static_cast<double>(lowest_N),
              static_cast<double>(largest_step_N));
  EXPECT_NEAR(before_N, 3.0F, 0.05F);
  EXPECT_NEAR(switch_tick, 200, 2);  // 50 ms down
  EXPECT_LT(largest_step_N, 0.1F);   // the tremble of a count is 0.05 N
  EXPECT_NEAR(bench.force_N(), 6.0F, 0.1F) << "the same plane, twice as stiff, holds on";
}

// Another scene forgets the contact: nothing pushes a tip out of what it did not enter.
TEST(SceneSwap, AnotherSceneBeginsAnew) {
  Bench bench;
  bench.start();
  bench.move({0, 0, 0.002}, 100);
  bench.move({0, 0, -0.003}, 400);
  bench.ticks(1000);
  EXPECT_GT(bench.force_N(), 2.9F);
  bench.load(1000.0F, 0.001F);
  bench.ticks(2000);
  EXPECT_EQ(bench.force_N(), 0.0F);
}

}  // namespace
}  // namespace thimble::test
