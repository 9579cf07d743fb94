// Orders for the axes in the controller: what reaches the motors, what ends it, and what the other arm feels meanwhile.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/unit/firmware/axis_rig.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using link::AxisEnd;
using link::AxisOrder;
using link::AxisPhase;

TEST(AxisSource, TheTorqueIsThatOfTheMotors) {
  Bench bench;
  write_param(bench, "gravity_compensation", 1U);
  arm_for_axes(bench);
  EXPECT_TRUE(any_current(bench.outputs)) << "the arm's weight is held";
  AxisOrder order = axis_torque(1, 0.03F);
  order.slope_N_m_s = 0.2F;
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  const std::uint64_t first = bench.inputs.tick + 1;
  for (int n = 0; n < 400; ++n) {
    bench.tick();
    ASSERT_TRUE(bench.outputs.arm[0].enable);
    EXPECT_NEAR(given_N_m(bench, 1), 0.03F + 0.2F * static_cast<float>(n) / 4000, 1e-6F);
    EXPECT_EQ(given_N_m(bench, 0), 0.0F) << "no weight is held";
    EXPECT_EQ(given_N_m(bench, 2), 0.0F);
    EXPECT_EQ(bench.force_N(), 0.0F);
    EXPECT_TRUE(bench.shown().moves_itself);
  }
  const link::AxisState state = bench.controller->axis_state();
  EXPECT_EQ(state.phase, AxisPhase::kDriving);
  EXPECT_EQ(state.end, AxisEnd::kNotYet);
  EXPECT_EQ(state.begin_tick, first);
  EXPECT_EQ(state.driven_ticks, 400U);
}

TEST(AxisSource, TheArmIsLetGoAfterwards) {
  Bench bench;
  arm_for_axes(bench);
  AxisOrder order = axis_torque(2, 0.03F, 0.05F);
  order.coast_s = 0.025F;
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  bench.ticks(200);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kDriving);
  for (int n = 0; n < 99; ++n) {
    bench.tick();
    EXPECT_EQ(axis_phase(bench), AxisPhase::kCoasting);
    EXPECT_EQ(bench.mode(), Mode::kArmed);
    EXPECT_FALSE(any_current(bench.outputs));
  }
  bench.tick();
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
  EXPECT_EQ(axis_end(bench), AxisEnd::kTime);
  EXPECT_EQ(bench.controller->axis_state().driven_ticks, 200U);
  EXPECT_EQ(bench.mode(), Mode::kDamping);
  EXPECT_FALSE(bench.shown().moves_itself);
  bench.ticks(1100);
  EXPECT_EQ(bench.mode(), Mode::kReady);
  EXPECT_FALSE(any_enabled(bench.outputs));
  EXPECT_EQ(bench.controller->fault(), Fault::kNone);
}

// An axis that lies along its own push has the lever of 0.02 m.
TEST(AxisSource, NoAxisPushesMoreThanTheMaxForce) {
  constexpr float kMax_N = 0.7F;
  Bench bench;
  write_param(bench, "max_force", kMax_N);
  arm_for_axes(bench);
  for (const float torque_N_m : {5.0F, -5.0F}) {
    for (std::uint8_t axis = 0; axis < 3; ++axis) {
      AxisOrder order = axis_torque(axis, torque_N_m, 0.001F);
      order.hold = true;
      for (std::size_t j = 0; j < 3; ++j) {
        order.stiffness_N_m_rad[j] = 1000.0F;
        order.to_rad[j] = torque_N_m;
      }
      ASSERT_EQ(bench.controller->request_axes(order), 0);
      for (int n = 0; n < 10; ++n) {
        bench.tick();
        const auto jacobian = bench.arms[0].at(bench.joints[0]).jacobian;
        for (std::size_t j = 0; j < 3; ++j) {
          const auto lever_m = static_cast<float>(jacobian.col(static_cast<int>(j)).norm());
          EXPECT_NEAR(given_N_m(bench, j), std::copysign(kMax_N * std::max(lever_m, 0.02F), torque_N_m),
                      1e-4F)
              << j;
        }
      }
    }
  }
}

struct Stop {
  const char* what;
  int ticks;  // until it is seen
  void (*stop)(Bench&);
};

TEST(AxisSource, EveryStopEndsItInItsTick) {
  const Stop kStops[] = {
      {"e-stop", 1, [](Bench& b) { b.inputs.e_stop = true; }},
      {"dead-man switch", 1, [](Bench& b) { b.inputs.dead_man = false; }},
      {"stop of a host", 1, [](Bench& b) { ASSERT_EQ(b.controller->request(Command::kStop), 0); }},
      {"disarm", 1, [](Bench& b) { ASSERT_EQ(b.controller->request(Command::kDisarm), 0); }},
      {"fault of a drive", 1, [](Bench& b) { b.inputs.arm[0].drive_fault = true; }},
      {"host that is silent for 0.5 s", 2001, [](Bench& b) { b.alive = false; }},
  };
  for (const Stop& stop : kStops) {
    for (const float stop_time_s : {0.0F, 0.25F}) {
      for (const bool holds : {false, true}) {
        Bench bench;
        write_param(bench, "gravity_compensation", 0U);
        write_param(bench, "stop_time", stop_time_s);
        write_param(bench, "link_timeout", 10.0F);
        arm_for_axes(bench);
        AxisOrder order = axis_torque(1, 0.03F, holds ? 0.001F : 1.0F);
        order.hold = holds;
        order.to_rad[1] = bench.shown().arm[0].joint_rad[1] + 1.0F;
        order.stiffness_N_m_rad[1] = holds ? 0.03F : 0.0F;
        ASSERT_EQ(bench.controller->request_axes(order), 0);
        bench.ticks(100);
        ASSERT_EQ(axis_phase(bench), holds ? AxisPhase::kHolding : AxisPhase::kDriving);
        ASSERT_GT(given_N_m(bench, 1), 0.025F);
        stop.stop(bench);
        bench.ticks(stop.ticks - 1);
        ASSERT_EQ(bench.mode(), Mode::kArmed) << stop.what;
        bench.tick();
        EXPECT_NE(bench.mode(), Mode::kArmed) << stop.what;
        EXPECT_EQ(axis_phase(bench), AxisPhase::kNone) << stop.what;
        EXPECT_EQ(axis_end(bench), holds ? AxisEnd::kTime : AxisEnd::kStopped) << stop.what;
        // The brake of a tip that stands still gives nothing either; a tremble of the bench is less than 0.2 N.
        EXPECT_LT(std::abs(given_N_m(bench, 1)), 0.02F) << stop.what;
        if (stop_time_s == 0.0F) {
          EXPECT_FALSE(any_current(bench.outputs)) << stop.what;
        }
        bench.ticks(1100);
        EXPECT_FALSE(any_enabled(bench.outputs)) << stop.what;
      }
    }
  }
}

// Its brake takes over where the axes were driven: a tip that moves is slowed.
TEST(AxisSource, TheBrakeTakesOver) {
  Bench bench;
  arm_for_axes(bench);
  ASSERT_EQ(bench.controller->request_axes(axis_torque(1, 0.03F, 1.0F)), 0);
  bench.move({0, 0, 0.02}, 400);  // 0.2 m/s
  ASSERT_EQ(bench.mode(), Mode::kArmed);
  bench.inputs.dead_man = false;
  bench.move({0, 0, 0.02025}, 5);
  ASSERT_EQ(bench.mode(), Mode::kDamping);
  EXPECT_LT(bench.shown().arm[0].force_N.z(), -0.2F);
  EXPECT_TRUE(any_current(bench.outputs));
}

TEST(AxisSource, TheScenesForceComesBack) {
  Bench bench;
  arm_for_axes(bench);
  ASSERT_EQ(bench.controller->request_axes(axis_hold(bench, 0.05F)), 0);
  bench.ticks(500);
  bench.move({0, 0, -0.0095}, 400);
  EXPECT_EQ(bench.force_N(), 0.0F) << "the scene gives none meanwhile";
  ASSERT_EQ(bench.controller->request(Command::kEndMove), 0);
  bench.tick();
  EXPECT_EQ(bench.mode(), Mode::kArmed);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
  EXPECT_FALSE(bench.shown().moves_itself);
  EXPECT_LT(bench.shown().ramp, 0.01F);
  bench.move({0, 0, -0.012}, 300);
  EXPECT_NEAR(bench.force_N(), 2.0F * bench.shown().ramp, 0.15F) << "ramped";
  bench.ticks(
      4000);  // the hand came in while the force was small, and is not given more than it has paid for
  EXPECT_NEAR(bench.force_N(), 2.0F, 0.1F);
}

// Torques alone end by their time, and whether an axis moves is what they find out; who follows a place needs to see the axes.
TEST(AxisSource, AFrozenEncoderEndsWhatFollowsAPlace) {
  for (const bool follows : {false, true}) {
    Bench bench;
    write_param(bench, "max_force", 20.0F);
    write_param(bench, "encoder_frozen", 0.05F);
    arm_for_axes(bench);
    const kinematics::AxisData& axis = bench.data[0].axis[1];
    AxisOrder order = axis_torque(1, 0, 2.0F);
    order.amplitude_N_m = 0.2F * axis.torque_per_ampere() * axis.motor.peak_current_A;
    order.frequency_Hz = 10.0F;
    order.stiffness_N_m_rad[1] = follows ? 1e-3F : 0.0F;
    order.to_rad[1] = bench.shown().arm[0].joint_rad[1];
    ASSERT_EQ(bench.controller->request_axes(order), 0);
    bench.ticks(2000);
    ASSERT_EQ(bench.controller->fault(), Fault::kNone) << "it trembles";
    bench.frozen = true;
    bench.ticks(2000);
    if (follows) {
      EXPECT_EQ(bench.controller->fault(), Fault::encoder_frozen);
      EXPECT_EQ(axis_end(bench), AxisEnd::kStopped);
    } else {
      EXPECT_EQ(bench.controller->fault(), Fault::kNone);
      EXPECT_EQ(axis_phase(bench), AxisPhase::kDriving);
    }
  }
}

// A joint that a torque leaves between two counts: what follows is compared with itself.
TEST(AxisSource, AnOrderIsNotJudgedByTheTorquesOfTheLastOne) {
  Bench bench;
  write_param(bench, "max_force", 20.0F);
  arm_for_axes(bench);
  const kinematics::AxisData& axis = bench.data[0].axis[1];
  const float peak_N_m = axis.torque_per_ampere() * axis.motor.peak_current_A;
  const float at_rad = bench.shown().arm[0].joint_rad[1];
  bench.frozen = true;
  AxisOrder order = axis_torque(1, 0);
  order.hold = true;
  order.stiffness_N_m_rad[1] = 1.0F;
  for (const float part : {0.2F, -0.1F}) {  // 0.3 of the peak apart
    order.to_rad[1] = at_rad + part * peak_N_m;
    ASSERT_EQ(bench.controller->request_axes(order), 0);
    bench.ticks(1000);
    EXPECT_EQ(bench.controller->fault(), Fault::kNone) << part;
    EXPECT_NEAR(given_N_m(bench, 1), part * peak_N_m, 1e-3F);
  }
  order.move_s = 0.05F;
  order.to_rad[1] = at_rad + 0.3F * peak_N_m;
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  bench.ticks(1000);
  EXPECT_EQ(bench.controller->fault(), Fault::encoder_frozen) << "by its own";
}

TEST(AxisSource, ATorqueThatIsNotFiniteTrips) {
  Bench bench;
  arm_for_axes(bench);
  AxisOrder order = axis_torque(1, 0);
  order.to_rad[1] = 100.0F;
  order.stiffness_N_m_rad[1] = 3e38F;
  ASSERT_TRUE(bench.controller->axes_in_range(order));
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  bench.tick();
  EXPECT_EQ(bench.controller->fault(), Fault::torque_not_finite);
  EXPECT_FALSE(any_current(bench.outputs));
  bench.tick();
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
}

std::unique_ptr<Bench> two_arms() {
  firmware::Config config;
  config.arm_count = 2;
  config.arm[1].base.home_m = {0.3F, 0, 0};
  auto bench = std::make_unique<Bench>(config);
  arm_for_axes(*bench);
  return bench;
}

TEST(AxisSource, TheOtherArmFeelsTheScene) {
  const auto rig = two_arms();
  Bench& bench = *rig;
  ASSERT_EQ(bench.controller->request_axes(axis_torque(1, 0.03F, 1.0F)), 0);
  bench.move({0.3, 0, -0.012}, 400, 1);
  for (int n = 0; n < 1000; ++n) {
    bench.tick();
    ASSERT_NEAR(bench.force_N(1), 2.0F, 0.1F);  // the tremble is 0.05 mm
    EXPECT_NEAR(given_N_m(bench, 1, 0), 0.03F, 1e-6F);
  }
  EXPECT_EQ(bench.controller->axis_state().driven_ticks, 1400U);
}

// An order for the other arm: the one that was held feels the scene again, and does not get the torques of the other one.
TEST(AxisSource, AnOrderForTheOtherArmLetsTheFirstGo) {
  const auto rig = two_arms();
  Bench& bench = *rig;
  AxisOrder hold = axis_hold(bench, 0.05F, 0);
  for (float& to_rad : hold.to_rad) to_rad += 0.5F;  // it pulls
  ASSERT_EQ(bench.controller->request_axes(hold), 0);
  bench.ticks(500);
  ASSERT_EQ(axis_phase(bench), AxisPhase::kHolding);
  ASSERT_GT(given_N_m(bench, 1, 0), 0.02F);
  AxisOrder order = axis_hold(bench, 0.05F, 1);  // from where arm 1 is, and so no torque
  order.axis = 2;
  order.offset_N_m = 0.04F;
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  bench.tick();
  EXPECT_NEAR(given_N_m(bench, 0, 1), 0.0F, 1e-4F);
  EXPECT_NEAR(given_N_m(bench, 2, 1), 0.04F, 1e-4F);
  EXPECT_LT(bench.shown().ramp, 0.01F) << "the scene's force comes back by a ramp";
  bench.ticks(99);
  EXPECT_EQ(bench.controller->axis_state().driven_ticks, 100U) << "one torque a tick";
  bench.ticks(900);
  bench.move({0, 0, -0.012}, 400, 0);
  bench.ticks(10);
  EXPECT_NEAR(bench.force_N(0), 2.0F, 0.1F);
  EXPECT_EQ(bench.force_N(1), 0.0F);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kHolding);
}

}  // namespace
}  // namespace thimble::test
