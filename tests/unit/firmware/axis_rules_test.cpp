// What an order for the axes is refused for, and its ranges.
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/firmware/axis_rig.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using link::AxisOrder;
using link::AxisPhase;

void disarm_and_wait(Bench& bench) {
  ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
  bench.ticks(1100);
}

TEST(AxisRules, EveryConditionIsNamed) {
  struct Case {
    firmware::Condition condition;
    void (*spoil)(Bench&);
  };
  const Case kCases[] = {
      {firmware::kMovesNotAllowed,
       [](Bench& b) {
         disarm_and_wait(b);
         write_param(b, "allow_moves", 0U);
         b.arm();
         b.ticks(900);
       }},
      {firmware::kHostRenders,
       [](Bench& b) {
         disarm_and_wait(b);
         write_param(b, "host_forces", 1U);
         b.arm();
       }},
      {firmware::kNotArmed, [](Bench& b) { disarm_and_wait(b); }},
      {firmware::kInContact,
       [](Bench& b) {
         b.move({0, 0, -0.012}, 400);
       }},
      {firmware::kLinkDown,
       [](Bench& b) {
         b.alive = false;
         b.ticks(2100);  // 0.525 s: arming would still do
         EXPECT_EQ(b.mode(), Mode::kArmed);
       }},
      {firmware::kRampRuns,
       [](Bench& b) {
         disarm_and_wait(b);
         b.arm();
       }},
      {firmware::kFaultLatched, [](Bench& b) { (void)b.controller->request(Command::kStop); }},
      {firmware::kMoveUnderWay,
       [](Bench& b) { ASSERT_EQ(b.controller->request_axes(axis_torque(0, 0.01F)), 0); }},
      {firmware::kMoveUnderWay,
       [](Bench& b) {
         ASSERT_EQ(b.controller->request_move({0, true, Vec3(0, 0, 0.005F), 0.02F, 1.0F}), 0);
       }},
  };
  for (const Case& c : kCases) {
    Bench bench;
    arm_for_axes(bench);
    c.spoil(bench);
    bench.ticks(5);
    const link::AxisState before = bench.controller->axis_state();
    const Conditions refused = bench.controller->request_axes(axis_torque(1, 0.02F));
    EXPECT_NE(refused & c.condition, 0) << c.condition;
    bench.ticks(2);
    EXPECT_EQ(bench.controller->axis_state().begin_tick, before.begin_tick) << c.condition;
  }
}

TEST(AxisRules, AMoveWaitsForTheAxes) {
  Bench bench;
  arm_for_axes(bench);
  AxisOrder order = axis_torque(1, 0.01F);
  order.coast_s = 0.05F;
  ASSERT_EQ(bench.controller->request_axes(order), 0);
  const firmware::MoveOrder move{0, true, Vec3(0, 0, 0.005F), 0.02F, 1.0F};
  EXPECT_EQ(bench.controller->request_move(move), firmware::kMoveUnderWay) << "ordered";
  bench.ticks(10);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kDriving);
  EXPECT_EQ(bench.controller->request_move(move), firmware::kMoveUnderWay) << "driving";
  bench.ticks(400);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kCoasting);
  EXPECT_EQ(bench.controller->request_move(move), firmware::kMoveUnderWay) << "coasting";
  EXPECT_EQ(bench.controller->request_axes(order), firmware::kMoveUnderWay);
}

// What holds gives way: to the next order, and to a move, and a move's hold to an order.
TEST(AxisRules, WhatHoldsGivesWay) {
  Bench bench;
  arm_for_axes(bench);
  const firmware::MoveOrder move{0, false, Vec3(0, 0, 0.0005F), 0.02F, 1.0F};
  ASSERT_EQ(bench.controller->request_axes(axis_hold(bench, 0.1F)), 0);
  bench.ticks(500);
  ASSERT_EQ(axis_phase(bench), AxisPhase::kHolding);
  ASSERT_EQ(bench.controller->request_axes(axis_hold(bench, 0.1F)), 0);
  bench.tick();
  EXPECT_EQ(axis_phase(bench), AxisPhase::kDriving);
  bench.ticks(500);
  ASSERT_EQ(bench.controller->request_move(move), 0);
  bench.tick();
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
  EXPECT_EQ(bench.controller->move_state().phase, link::MovePhase::kGoing);
  for (int i = 0; i < 2000 && bench.controller->move_state().phase == link::MovePhase::kGoing; ++i) {
    bench.place(bench.shown().arm[0].god_object_m.cast<double>());
    bench.tick();
  }
  ASSERT_EQ(bench.controller->move_state().phase, link::MovePhase::kHolding);
  ASSERT_EQ(bench.controller->request_axes(axis_torque(1, 0.02F)), 0);
  bench.tick();
  EXPECT_EQ(bench.controller->move_state().phase, link::MovePhase::kNone);
  EXPECT_NEAR(given_N_m(bench, 1), 0.02F, 1e-6F);
  EXPECT_EQ(given_N_m(bench, 0), 0.0F);
}

TEST(AxisRules, AreCheckedAgainInTheTick) {
  Bench bench;
  arm_for_axes(bench);
  ASSERT_EQ(bench.controller->request_axes(axis_torque(1, 0.02F)), 0);
  bench.inputs.e_stop = true;
  bench.tick();
  EXPECT_FALSE(bench.shown().moves_itself);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
  // The order is gone: what comes next is a move.
  bench.inputs.e_stop = false;
  bench.ticks(1500);
  ASSERT_EQ(bench.controller->request(Command::kClear), 0);
  bench.tick();
  bench.arm();
  bench.ticks(900);
  ASSERT_EQ(bench.controller->request_move({0, true, Vec3(0, 0, 0.005F), 0.02F, 1.0F}), 0);
  bench.ticks(3);
  EXPECT_EQ(axis_phase(bench), AxisPhase::kNone);
  EXPECT_EQ(bench.controller->move_state().phase, link::MovePhase::kGoing);
}

TEST(AxisRules, RangesAreKept) {
  Bench bench;
  arm_for_axes(bench);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kMost = std::numeric_limits<float>::infinity();
  const auto in_range = [&](auto&& change) {
    AxisOrder order = axis_torque(2, 0.02F);
    change(order);
    return bench.controller->axes_in_range(order);
  };
  EXPECT_TRUE(in_range([](AxisOrder&) {}));
  EXPECT_TRUE(in_range([](AxisOrder& o) {
    o.driven_s = o.move_s = 60;
    o.coast_s = 5;
    o.frequency_Hz = 1000;
  }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.arm = 1; }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.axis = 3; }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.driven_s = 60.1F; }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.move_s = 60.1F; }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.coast_s = 5.1F; }));
  EXPECT_FALSE(in_range([](AxisOrder& o) { o.frequency_Hz = 1000.1F; }));
  using Field = float AxisOrder::*;
  for (const Field field :
       {&AxisOrder::driven_s, &AxisOrder::coast_s, &AxisOrder::offset_N_m, &AxisOrder::slope_N_m_s,
        &AxisOrder::amplitude_N_m, &AxisOrder::frequency_Hz, &AxisOrder::most_energy_J, &AxisOrder::move_s})
    for (const float bad : {kNan, kMost}) EXPECT_FALSE(in_range([&](AxisOrder& o) { o.*field = bad; }));
  for (const Field field : {&AxisOrder::driven_s, &AxisOrder::coast_s, &AxisOrder::frequency_Hz,
                            &AxisOrder::most_energy_J, &AxisOrder::move_s})
    EXPECT_FALSE(in_range([&](AxisOrder& o) { o.*field = -1e-3F; }));
  for (const Field field : {&AxisOrder::offset_N_m, &AxisOrder::slope_N_m_s, &AxisOrder::amplitude_N_m})
    EXPECT_TRUE(in_range([&](AxisOrder& o) { o.*field = -1; }));
  for (std::size_t j = 0; j < link::kMaxJoints; ++j) {
    for (const float bad : {kNan, kMost, -1e-3F}) {
      EXPECT_EQ(in_range([&](AxisOrder& o) { o.to_rad[j] = bad; }), bad < 0);
      EXPECT_FALSE(in_range([&](AxisOrder& o) { o.stiffness_N_m_rad[j] = bad; }));
      EXPECT_FALSE(in_range([&](AxisOrder& o) { o.damping_N_m_s_rad[j] = bad; }));
      EXPECT_FALSE(in_range([&](AxisOrder& o) { o.most_torque_N_m[j] = bad; }));
      EXPECT_FALSE(in_range([&](AxisOrder& o) { o.most_way_rad[j] = bad; }));
      EXPECT_FALSE(in_range([&](AxisOrder& o) { o.most_speed_rad_s[j] = bad; }));
    }
  }
}

}  // namespace
}  // namespace thimble::test
