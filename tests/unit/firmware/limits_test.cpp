// What the hand can be given: clamp, slew, ramp, current and thermal limits over the real renderer and a tip
// that jumps about.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <random>

#include "firmware/core/force_limits.h"
#include "kinematics/built_in_arms.h"
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
    const Vec3 left = firmware::remaining(last, force);
    EXPECT_LE(left.norm(), std::min(last.norm(), force.norm()) * (1 + 1e-5F));
    EXPECT_LE((firmware::remaining(last, 0.3F * last) - 0.3F * last).norm(), 1e-5F) << "it falls at once";
  }
  std::printf("worst turn by the clamp: %.2g rad\n", static_cast<double>(worst_angle));
  EXPECT_LT(worst_angle, 1e-6F);
}

// The most that the force changes in a tick of 0.25 ms, from now on.
float largest_step_N(Bench& bench, int ticks) {
  float largest = 0;
  for (int i = 0; i < ticks; ++i) {
    const Vec3 before_N = bench.shown().arm[0].force_N;
    bench.tick();
    largest = std::max(largest, (bench.shown().arm[0].force_N - before_N).norm());
  }
  return largest;
}

// Lowered, the force falls by 50 N/s. Raised, it rises slowly until the wanted force has been below it: no hand is pushed out.
TEST(Limits, AChangeOfTheMaximumInContactTakesTime) {
  Bench bench;
  set_param(bench, "max_force", 6.0F);
  bench.start();
  bench.ticks(1000);  // the ramp
  bench.move({0, 0, -0.006}, 1000);
  bench.ticks(2000);
  ASSERT_GT(bench.force_N(), 5.9F);
  set_param(bench, "max_force", 2.4F);
  const float down_N = largest_step_N(bench, 2000);
  std::printf("6 N to 2.4 N: at most %.4f N a tick\n", static_cast<double>(down_N));
  EXPECT_NEAR(bench.force_N(), 2.4F, 1e-3F);
  EXPECT_LE(down_N, 0.0126F);
  set_param(bench, "max_force", 6.0F);
  bench.ticks(2000);
  EXPECT_LT(bench.force_N(), 2.9F) << "5 mW, 6 mm deep";
  bench.move({0, 0, -0.002}, 400);
  EXPECT_NEAR(bench.force_N(), 2.0F, 0.05F);
  bench.move({0, 0, -0.006}, 1000);
  EXPECT_GT(bench.force_N(), 5.7F);
}

void load_rough(Bench& bench, double stiffness_N_m, double height_m, double friction) {
  ASSERT_EQ(bench.controller->load_scene(plane_image(static_cast<float>(stiffness_N_m),
                                                     static_cast<float>(height_m), 0.0F, "rough", 1,
                                                     static_cast<float>(friction))),
            firmware::StoreStatus::kOk);
}

// A wall is stroked for long, and its stiffness changed by swaps: it is the wall that it should be a few seconds later.
TEST(Limits, AWallThatWasSwappedIsItselfAgain) {
  for (const double friction : {0.0, 0.5}) {
    Bench bench;
    bench.start();
    load_rough(bench, 300, 0, friction);
    bench.ticks(2000);
    bench.move({0, 0, 0.001}, 400);
    bench.move({0, 0, -0.003}, 400);
    const auto stroke = [&](int times) {
      for (int i = 0; i < times; ++i)
        for (const double x_m : {0.01, -0.01}) bench.move({x_m, 0, -0.003}, 800);
    };
    stroke(20);
    for (const double stiffness_N_m : {1000, 300, 1000, 300, 1000, 300, 1000}) {
      load_rough(bench, stiffness_N_m, 0, friction);
      bench.ticks(1200);
    }
    const float at_once_N = bench.force_N();
    stroke(5);
    const double wanted_N = 3 * std::sqrt(1 + friction * friction);
    std::printf("friction %.1f: %.2f N at once, %.2f N after 2 s, wanted %.2f N\n", friction,
                static_cast<double>(at_once_N), static_cast<double>(bench.force_N()), wanted_N);
    EXPECT_GT(bench.force_N(), 0.97 * wanted_N);
  }
}

// A wall is pressed and left, by a hand that stands still at times, while limits are written and scenes are swapped. The hand gets no
// more than it gave, but for the steps of the ticks (K dx^2 / 2 each) and 10 mW: a debt is forgotten, and a maximum rises, by 5 mW each.
TEST(Limits, RandomWritesAndSwapsInContactGiveNoEnergy) {
  constexpr int kOperations = 10000;
  std::mt19937 random(5);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  Bench bench;
  bench.start();
  bench.ticks(1000);
  double stiffness_N_m = 1000, stiffest_N_m = 1000, height_m = 0;
  Eigen::Vector3d at_m = bench.arms[0].at(bench.joints[0]).tip_m;
  Eigen::Vector3d target_m = at_m;
  double speed_m_s = 0.1, given_J = 0, bound_J = 0, worst_J = -1, pressed_J = 0;
  int contacts = 0, written = 0, swapped = 0, over = 0, since_swap = 0;
  bool moved = false;  // by the last swap, which fades out and in
  Vec3 tip_m = bench.shown().arm[0].tip_m, force_N = Vec3::Zero();
  while (written + swapped < kOperations) {
    if (random() % 30 == 0) {
      target_m = Eigen::Vector3d(within(-.01, .01), 0, within(-.008, .004));
      speed_m_s = std::pow(10, within(-2.5, -.5));
    }
    const double step_m = speed_m_s * static_cast<double>(bench.config.period_s);
    for (const int axis : {0, 2}) at_m[axis] += std::clamp(target_m[axis] - at_m[axis], -step_m, step_m);
    bench.place(at_m);
    if (random() % 40 == 0) {
      const auto kind = random() % 8;
      const bool moves = random() % 2 == 0;
      if (kind == 0 && since_swap > (moved ? 1000 : 8)) {
        stiffness_N_m = within(200, 2000);
        if (moves) height_m = within(-.003, .003);
        moved = moves;
        load_rough(bench, stiffness_N_m, height_m, within(0, .8));
        stiffest_N_m = std::max(stiffest_N_m, stiffness_N_m);
        ++swapped;
        since_swap = 0;
      } else {
        if (kind % 2 == 0) {
          set_param(bench, "max_force", static_cast<float>(within(.2, 12)));
        } else {
          set_param(bench, "force_slew", static_cast<float>(std::pow(10, within(2, 4.5))));
        }
        ++written;
      }
    }
    bench.tick();
    ++since_swap;
    ASSERT_EQ(bench.mode(), Mode::kArmed);
    const auto& arm = bench.shown().arm[0];
    const Vec3 moved_m = arm.tip_m - tip_m;
    const double work_J = static_cast<double>(force_N.dot(moved_m));
    given_J += work_J;
    pressed_J += std::max(-work_J, 0.0);
    bound_J += stiffest_N_m * static_cast<double>(moved_m.squaredNorm()) / 2 +
               1e-2 * static_cast<double>(bench.config.period_s);
    worst_J = std::max(worst_J, given_J - bound_J);
    tip_m = arm.tip_m;
    force_N = arm.force_N;
    if (arm.contacts == 0 && force_N.isZero()) {
      contacts += given_J != 0 ? 1 : 0;
      over += given_J > bound_J + 1e-6 ? 1 : 0;
      given_J = bound_J = 0;
      stiffest_N_m = stiffness_N_m;
    }
  }
  std::printf("%d contacts, %d writes, %d swaps, %.1f J pressed in: over the bound %d, at most %.3g mJ\n",
              contacts, written, swapped, pressed_J, over, 1e3 * worst_J);
  EXPECT_GT(contacts, 300);
  EXPECT_GT(pressed_J, 1.0);
  EXPECT_LE(worst_J, 1e-6);
}

TEST(Limits, OutsideContactThereIsNoForceWhateverTheSlewLimit) {
  for (const float slew_N_s : {100.0F, 1000.0F, 100000.0F}) {
    Bench bench;
    set_param(bench, "force_slew", slew_N_s);
    bench.start();
    bench.ticks(1000);
    bench.move({0, 0, -0.006}, 1000);
    bench.ticks(2000);
    ASSERT_GT(bench.force_N(), 5.0F);
    double outside_N = 0;
    for (int i = 1; i <= 400; ++i) {
      bench.place({0, 0, -0.006 + 2e-5 * i});
      bench.tick();
      if (bench.shown().arm[0].contacts == 0)
        outside_N = std::max(outside_N, static_cast<double>(bench.force_N()));
    }
    std::printf("slew limit %.0f N/s: outside contact %.3f N\n", static_cast<double>(slew_N_s), outside_N);
    EXPECT_EQ(outside_N, 0.0);
  }
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
    bench.let_jump();
    set_param(bench, "max_force", max_N);
    set_param(bench, "force_slew", slew_N_s);
    bench.load(100.0F + 9000.0F * unit(random), -0.0002F, 20.0F * unit(random));
    bench.home();
    bench.arm();
    const float bound_N = std::min(max_N, bench.data[0].max_force_N);
    const float peak_A = bench.data[0].axis[0].motor.peak_current_A;
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
        worst_slew = std::max(worst_slew, (arm.force_N - firmware::remaining(last_N, arm.force_N)).norm() /
                                              (slew_N_s * bench.config.period_s));
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

// A wall that is met during the ramp gives back what was paid, and is itself a second later.
TEST(Limits, ForceRampsUpOver200ms) {
  Bench bench;
  bench.load(1000.0F,
             0.004F);  // the tip, at home, is 4 mm inside: the god object starts there, so lift and press
  bench.home();
  bench.move({0, 0, 0.01}, 200);
  bench.arm();
  bench.move({0, 0, 0.001}, 200);  // 3 mm deep, 50 ms after arming
  float most = 0;
  for (int i = 200; i < 850; ++i) {
    bench.tick();
    most = std::max(most, bench.force_N() / (3.0F * bench.shown().ramp));
  }
  const float ramped_N = bench.force_N();
  bench.ticks(4000);
  std::printf("force over the ramp's: at most %.3f; after the ramp %.3f N, a second later %.3f N of 3\n",
              static_cast<double>(most), static_cast<double>(ramped_N), static_cast<double>(bench.force_N()));
  EXPECT_LE(most, 1.01F);
  EXPECT_GT(ramped_N, 1.0F);
  EXPECT_LT(ramped_N, 2.0F);
  EXPECT_NEAR(bench.force_N(), 3.0F, 0.08F) << "the hand trembles by two counts";
}

// Heat of a held press against the closed form of the two nodes, and derating that keeps the current's
// direction.
TEST(Thermal, FollowsTheTwoNodes) {
  const kinematics::MotorModel motor = kinematics::built_in_arm("premium-1.5").axis[0].motor;
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

// The loop stands still for up to a quarter of an hour, at random, with drives that are off 5 ms later: the model is never cooler than the
// motor, and never below ambient.
TEST(Thermal, IsNotBelowTheMotorHoweverLongTheLoopStands) {
  constexpr float kAmbient_C = 25, kPeriod_s = 1e-3F;
  constexpr double kDrivesOff_s = 5e-3;
  Random random(1);
  double below_K = 0;
  for (const std::string_view name : kinematics::built_in_arms()) {
    const kinematics::MotorModel motor = kinematics::built_in_arm(name).axis[0].motor;
    const auto to_housing_K_W = static_cast<double>(motor.winding_to_housing_K_W),
               to_ambient_K_W = static_cast<double>(motor.housing_to_ambient_K_W);
    const double c_w = static_cast<double>(motor.winding_time_constant_s) / to_housing_K_W;
    const double c_h = static_cast<double>(motor.housing_time_constant_s) / to_ambient_K_W;
    firmware::MotorHeat heat;
    double winding = 0, housing = 0;
    const auto pass = [&](float current_A, double seconds) {
      const auto steps = static_cast<int>(std::ceil(seconds / 0.01));
      const double h = seconds / std::max(steps, 1);
      for (int i = 0; i < steps; ++i) {
        const double power =
            static_cast<double>(current_A * current_A * motor.resistance_ohm) * (1 + 0.00393 * winding);
        const double flow = (winding - housing) / to_housing_K_W;
        winding += (power - flow) / c_w * h;
        housing += (flow - housing / to_ambient_K_W) / c_h * h;
      }
    };
    for (int i = 0; i < 300; ++i) {
      const float current_A = random.below(3) == 0 ? 0 : static_cast<float>(random.uniform(0, 1.5));
      for (int tick = 0; tick < 1000; ++tick) {
        heat.add(motor, current_A, kAmbient_C, kPeriod_s);
        if (tick % 10 == 9) pass(current_A, 0.01);
      }
      const double gap_s = std::exp(random.uniform(std::log(1e-3), std::log(900.0)));
      heat.add(motor, current_A, kAmbient_C, static_cast<float>(gap_s));
      pass(current_A, std::min(gap_s, kDrivesOff_s));
      pass(0, std::max(gap_s - kDrivesOff_s, 0.0));
      below_K = std::max(below_K, winding - static_cast<double>(heat.heat().winding_K));
    }
  }
  figure("model below the motor after the loop stood still, K", below_K, "<= 0.5");
  EXPECT_LE(below_K, 0.5);
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
  const Vec3 first_A = bench.shown().arm[0].current_A.head<3>();
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
  const Vec3 last_A = bench.shown().arm[0].current_A.head<3>();
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

// Other materials in contact are felt in the next tick, with no gap and no step up.
TEST(SceneSwap, OtherMaterialsAreFeltAtOnce) {
  for (const double friction : {0.0, 0.5}) {
    Bench bench;
    bench.start();
    load_rough(bench, 1000, 0, friction);
    bench.ticks(2000);
    bench.move({0, 0, 0.002}, 100);
    bench.move({0, 0, -0.003}, 400);
    bench.ticks(1000);
    const float before_N = bench.force_N();
    EXPECT_NEAR(before_N, 3.0F, 0.05F);

    load_rough(bench, 500, 0, friction);
    bench.tick();
    EXPECT_NEAR(bench.force_N(), 1.5F, 0.05F) << "softer";
    load_rough(bench, 2000, 0, friction);
    EXPECT_LT(largest_step_N(bench, 4), 0.11F) << "stiffer: the tremble of a count is 0.1 N";
    EXPECT_NEAR(bench.force_N(), 1.5F, 0.1F) << "the hand has not paid for more";
    bench.ticks(400);
    EXPECT_NEAR(bench.force_N(), 6.0F * (2.25F + 0.5F) / 9.0F, 0.15F) << "0.1 s later by 5 mW";
    bench.move({0, 0, 0.001}, 400);
    bench.move({0, 0, -0.003}, 400);
    EXPECT_NEAR(bench.force_N(), 6.0F, 0.15F) << "touched again it is the wall that it should be";
  }
}

// Another shape in contact: the force goes down and up again, and never further than the slew limit in a tick.
TEST(SceneSwap, FadesInContact) {
  Bench bench;
  bench.start();
  bench.ticks(1000);
  bench.move({0, 0, 0.002}, 100);
  bench.move({0, 0, -0.003}, 400);
  bench.ticks(1000);
  const float before_N = bench.force_N();
  bench.load(2000.0F, -1e-6F);
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
  EXPECT_GT(bench.force_N(), 3.0F) << "the same plane, twice as stiff, holds on";
  EXPECT_LT(bench.force_N(), 6.0F) << "the hand has paid for half of it";
  bench.ticks(4000);
  EXPECT_NEAR(bench.force_N(), 6.0F, 0.1F);
}

// Another scene forgets the contact: nothing pushes a tip out of what it did not enter.
TEST(SceneSwap, AnotherSceneBeginsAnew) {
  Bench bench;
  bench.start();
  bench.ticks(1000);
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
