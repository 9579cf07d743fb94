// Bodies that sleep: they cost nothing, and nobody feels it (control/bodies/sleep.cpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

constexpr double kBoxMass_kg = .1;

std::string sleeper(const std::string& name, const Vector3d& at_m, const std::string& motion = "free",
                    const Vector3d& velocity_m_s = Vector3d::Zero()) {
  return R"({"name": ")" + name +
         R"(", "shape": {"box": {"size_m": [0.03, 0.03, 0.03]}}, "pose": {"position_m": )" + list(at_m) +
         R"(}, "material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}, "body": {"motion": ")" +
         motion + R"(", "mass_kg": )" + std::to_string(kBoxMass_kg) + R"(, "velocity_m_s": )" +
         list(velocity_m_s) + "}}";
}

const std::string kLevelFloor =
    R"({"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}})";

std::string stacks() {
  std::string text = std::string(kGravity) + R"("objects": [)" + kLevelFloor;
  for (int row = 0; row < 4; ++row)
    for (int i = 0; i < 4; ++i)
      text += ", " + sleeper(std::to_string(4 * row + i), {.05 * i, 0, .015 + .03 * row});
  return text + "]";
}

std::uint32_t work(const BodyRun& run) { return run.renderer().tick_work(); }

TEST(Sleep, StacksThatStandCostNothing) {
  BodyRun run(stacks());
  run.run(1);
  std::array<Vector3d, 16> at;
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = run.position_m(i);
  std::uint32_t most = 0;
  for (int tick = 0; tick < 4000; ++tick) {
    run.tick();
    most = std::max(most, work(run));
  }
  figure("16 boxes that stand: work of a tick, units", most, "0");
  EXPECT_EQ(most, 0U);
  for (std::size_t i = 0; i < at.size(); ++i) EXPECT_EQ(run.position_m(i), at[i]);
}

TEST(Sleep, ATouchActsInItsTick) {
  BodyRun run(R"("objects": [)" + sleeper("box", Vector3d::Zero(), "translate") + "]", {{-.05, 0, 0}});
  run.run(1);
  ASSERT_EQ(work(run), 0U);
  Vector3d tip(-.0151, 0, 0);
  run.tick({tip});
  for (int tick = 0; tick < 200 && run.force_N(0).isZero(0); ++tick) run.tick({tip += Vector3d(1e-6, 0, 0)});
  const Vector3d momentum = kBoxMass_kg * run.velocity_m_s(0);
  const Vector3d pushed = -run.force_N(0) * run.period_s();
  figure("the first push, uN s", 1e6 * pushed.x(), "> 0");
  figure("momentum in that tick, off by, uN s", 1e6 * (momentum - pushed).norm(), "0, 1e-3 of it");
  EXPECT_GT(pushed.x(), 0);
  EXPECT_LT((momentum - pushed).norm(), 1e-3 * pushed.norm());
}

TEST(Sleep, AStackThatIsTouchedWakesAsAWhole) {
  BodyRun run(stacks(), {{-.05, 0, .105}});
  run.run(1);
  ASSERT_EQ(work(run), 0U);
  // The top box of the first stack is pushed off; those beside it sleep on.
  for (int tick = 0; tick < 4000; ++tick) run.tick({Vector3d(-.05 + .02 * tick / 4000. + .02, 0, .105)});
  EXPECT_GT(run.position_m(12).x(), .003);
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_TRUE(run.velocity_m_s(i).isZero(0));
}

TEST(Sleep, ABodyThatComesWakesWhatItMeets) {
  // One box flies at two that touch each other and have slept long.
  BodyRun run(R"("objects": [)" + sleeper("a", Vector3d::Zero(), "translate") + ", " +
              sleeper("b", {.03, 0, 0}, "translate") + ", " +
              sleeper("c", {-.4, 0, 0}, "translate", {.2, 0, 0}) + "]");
  run.run(1);
  ASSERT_TRUE(run.velocity_m_s(0).isZero(0));
  run.run(2);
  const double sum = run.velocity_m_s(0).x() + run.velocity_m_s(1).x() + run.velocity_m_s(2).x();
  figure("momentum after the impact, of that before", sum / .2, "1, 1e-6");
  EXPECT_NEAR(sum / .2, 1, 1e-6);
  EXPECT_GT(run.velocity_m_s(1).x(), .05);
}

// It does not sway either before it sleeps. The contacts are as stiff as the rate of the ticks allows.
TEST(Sleep, AStackOfSixteenStandsFor20Seconds) {
  for (const double rate_Hz : {1000.0, 1400.0, 2000.0, 4000.0, 8000.0}) {
    std::string text = std::string(kGravity) + R"("objects": [)" + kLevelFloor;
    for (int i = 0; i < 16; ++i) text += ", " + sleeper(std::to_string(i), {0, 0, .015 + .03 * i});
    BodyRun run(text + "]", {}, rate_Hz);
    run.run(1);
    std::array<Vector3d, 16> at;
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = run.position_m(i);
    double moved_m = 0;
    while (run.time_s() < 20) {
      run.run(.5);
      for (std::size_t i = 0; i < at.size(); ++i)
        moved_m = std::max(moved_m, (run.position_m(i) - at[i]).norm());
    }
    const double sunk_m = .465 - run.position_m(15).z();
    const double may_sink_m = 1.1e-3 * (1000 / rate_Hz) * (1000 / rate_Hz) + 2e-5;
    const std::string what =
        "a stack of 16 equal boxes at " + std::to_string(static_cast<int>(rate_Hz)) + " Hz: ";
    figure(what + "moves in 19 s, um", 1e6 * moved_m, "<= 5");
    figure(what + "the top has sunk, um", 1e6 * sunk_m, "< " + std::to_string(1e6 * may_sink_m));
    EXPECT_LE(1e6 * moved_m, 5) << rate_Hz;
    EXPECT_LT(sunk_m, may_sink_m) << rate_Hz;
  }
}

std::string puck(const std::string& name, const Vector3d& at_m, const std::string& body) {
  return R"({"name": ")" + name +
         R"(", "shape": {"cylinder": {"radius_m": 0.015, "height_m": 0.02}}, "pose": {"position_m": )" +
         list(at_m) + R"(}, "material": {"stiffness_N_m": 1000}, "body": {"mass_kg": 0.1, )" + body + "}}";
}

// Their boxes overlap, they do not touch, and one comes to rest after the other.
TEST(Sleep, TwoThatLieSideBySideDoNotWakeEachOther) {
  BodyRun run(R"("objects": [)" + puck("a", Vector3d::Zero(), R"("motion": "translate")") + ", " +
              puck("b", {.0242, .0254, 0},
                   R"("motion": "translate", "damping_N_s_m": 1, "velocity_m_s": [0.001, 0, 0])") +
              "]");
  run.run(2);
  EXPECT_GT(run.position_m(1).x(), .02425);
  EXPECT_EQ(work(run), 0U);
}

TEST(Sleep, ControlsThatRestDo) {
  const auto button = [](const std::string& name, const Vector3d& at_m, const std::string& control) {
    return puck(name, at_m, R"("motion": "slide", "axis": [0, 0, -1], "control": {)" + control + "}");
  };
  BodyRun run(
      R"("objects": [)" +
          button(
              "at its stop", Vector3d::Zero(),
              R"("damping_N_s_m": 0.5, "low_m": 0, "high_m": 0.004, "curve_m_N": [[0, 0.3], [0.004, 2]])") +
          ", " +
          button(
              "on its spring", {.05, 0, 0},
              R"("damping_N_s_m": 2, "stiffness_N_m": 300, "rest_m": 0.002, "low_m": 0, "high_m": 0.004)") +
          ", " +
          button("held by friction", {.1, 0, 0}, R"("friction_N": 0.5, "low_m": -0.01, "high_m": 0.01)") +
          ", " +
          puck(
              "dial", {.15, 0, 0},
              R"("motion": "turn", "axis": [0, 0, 1], "pivot_m": [0.15, 0, 0], "control": {"damping_N_m_s_rad": 0.001, "low_deg": -90, "high_deg": 90, "detents": {"pitch_deg": 30, "torque_N_m": 0.01}})") +
          "]",
      {{0, -.05, 0}});
  run.run(2);
  EXPECT_EQ(work(run), 0U);
  EXPECT_NEAR(run.position_m(1).z(), -.002, 1e-8);
  // A press on the first one acts in its tick, and it comes back.
  Vector3d tip(0, 0, .0101);
  run.tick({tip});
  for (int tick = 0; tick < 2000; ++tick) run.tick({tip -= Vector3d(0, 0, 2e-6)});
  EXPECT_LT(run.position_m(0).z(), -.001);
  EXPECT_GT(run.force_N(0).z(), .3);
  for (int tick = 0; tick < 4000; ++tick) run.tick({tip += Vector3d(0, 0, 2e-6)});
  EXPECT_NEAR(run.position_m(0).z(), 0, 1e-9);
}

// A weak spring in a stiff damper: it goes on at 50 um/s.
TEST(Sleep, AControlThatCreepsDoesNot) {
  BodyRun run(
      R"("objects": [)" +
      puck(
          "slow", Vector3d::Zero(),
          R"("motion": "slide", "axis": [1, 0, 0], "control": {"stiffness_N_m": 1, "rest_m": 0.005, "damping_N_s_m": 100, "low_m": -0.01, "high_m": 0.01})") +
      "]");
  run.run(5);
  EXPECT_NEAR(run.position_m(0).x(), .005 * (1 - std::exp(-5 / 100.)), 1e-7);
}

TEST(Sleep, WhatDriftsSlowlyDoesNot) {
  BodyRun run(R"("objects": [)" + sleeper("box", Vector3d::Zero(), "free", {2e-4, 0, 0}) + "]");
  run.run(5);
  EXPECT_NEAR(run.velocity_m_s(0).x(), 2e-4, 1e-9);
}

}  // namespace
}  // namespace thimble::test
