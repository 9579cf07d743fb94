// The loop at every rate of the boards, up to 20 kHz: what is felt, what is limited and what stops does not depend on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "board/sim/simulation.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/sweep/wall_press.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::Vector3d;
using firmware::Command;
using firmware::Mode;

constexpr std::array<double, 4> kEachRate_Hz = {1000, 4000, 10'000, 20'000};
constexpr std::array<double, 2> kFastRates_Hz = {10'000, 20'000};

std::string at(double rate_Hz) { return " at " + std::to_string(std::lround(rate_Hz)) + " Hz"; }

TEST(Rates, AWallHoldsAPress) {
  for (const double rate_Hz : kFastRates_Hz) {
    for (const board::Hand& hand : {board::Hand{}, board::Hand{.01, 150, 1}}) {
      const host::Measured r = host::measure(
          host::WallPress{.rate_Hz = rate_Hz, .force_N = 5, .approach_m_s = .05, .hold_s = 2, .hand = hand});
      ASSERT_TRUE(r.is_ok()) << rate_Hz;
      figure("mean force of a press with 5 N, N," + at(rate_Hz), r.steady_force_N, "5, a fiftieth");
      figure("tip swing, um," + at(rate_Hz), 1e6 * r.tip_swing_m, "<= 59, two counts");
      EXPECT_NEAR(r.steady_force_N, 5, .1);
      EXPECT_LE(r.tip_swing_m, 59e-6);
      EXPECT_LE(r.tip_speed_rms_m_s, 1e-3);
    }
  }
}

// The mean of what friction takes while a hand drags the tip over a floor, over what the floor gives; and the most.
struct Drag {
  double mean = 0, most = 0;
};
Drag drag(double rate_Hz) {
  SceneBuilder scene;
  scene.plane({0, 0, 1}, -.01,
              {.stiffness_N_m = 1000, .damping_N_s_m = 2, .static_friction = .6F, .dynamic_friction = .4F});
  const std::vector<board::PathPoint> path{
      {0, {-.02, 0, 0}}, {.3, {-.02, 0, -.02}}, {.6, {-.02, 0, -.02}}, {1.6, {.02, 0, -.02}}};
  Drag drag;
  double along_N = 0, down_N = 0;
  const auto result =
      board::simulate(scene.bytes(), path, {.rate_Hz = rate_Hz}, [&](const board::LogRow& row) {
        if (row.force_N.z() < .5 || row.time_s < .3) return;
        drag.most = std::max(drag.most, row.force_N.head<2>().norm() / row.force_N.z());
        if (row.time_s < .8) return;
        along_N -= row.force_N.x();
        down_N += row.force_N.z();
      });
  EXPECT_EQ(result.status, board::SimulationStatus::kOk) << result.detail;
  drag.mean = along_N / down_N;
  return drag;
}

TEST(Rates, FrictionIsTheSame) {
  const Drag usual = drag(4000);
  for (const double rate_Hz : kEachRate_Hz) {
    const Drag now = drag(rate_Hz);
    figure("friction over a drag" + at(rate_Hz), now.mean, std::to_string(usual.mean) + ", a twentieth");
    figure("the most of a tick", now.most, "static friction .6, and the damping of the floor");
    EXPECT_NEAR(now.mean, usual.mean, .05 * usual.mean);
    EXPECT_LT(now.most, .65);
  }
}

// Pressed into a floor with about 3 N, the ramp done.
void press_down(board::SimBoard& board) {
  firmware::Controller& controller = board.controller();
  SceneBuilder scene;
  scene.plane({0, 0, 1}, -.005, {.stiffness_N_m = 1000, .damping_N_s_m = 2});
  ASSERT_EQ(controller.load_scene(scene.bytes()), firmware::StoreStatus::kOk);
  controller.keep_alive();
  board.tick();
  ASSERT_EQ(controller.request(Command::kHome), 0);
  board.step(.1);
  ASSERT_EQ(controller.request(Command::kArm), 0);
  board.step(.3);
  for (int i = 1; i <= 100; ++i) {
    board.hold(0, {0, 0, -.02 * i / 100});
    board.step(.005);
  }
  ASSERT_EQ(controller.mode(), Mode::kArmed);
  ASSERT_GT(controller.telemetry().arm[0].force_N.norm(), 2.0F);
}

TEST(Rates, AStopActsInItsTick) {
  using Stop = void (*)(board::SimBoard&);
  constexpr std::array<Stop, 3> kStops = {
      [](board::SimBoard& b) { b.set_e_stop(true); }, [](board::SimBoard& b) { b.set_dead_man(false); },
      [](board::SimBoard& b) { EXPECT_EQ(b.controller().request(Command::kStop), 0); }};
  for (const double rate_Hz : kEachRate_Hz) {
    for (const Stop stop : kStops) {
      board::SimBoard board({.rate_Hz = rate_Hz});
      press_down(board);
      stop(board);
      board.tick();
      EXPECT_EQ(board.controller().mode(), Mode::kDamping) << rate_Hz;
      EXPECT_LT(board.controller().telemetry().arm[0].force_N.norm(), .5F) << rate_Hz;
      board.step(.26);
      EXPECT_FALSE(board.driven(0)) << rate_Hz;
    }
  }
}

// Times in seconds stay seconds.
TEST(Rates, RampAndSilenceTakeTheirTime) {
  for (const double rate_Hz : kEachRate_Hz) {
    board::SimBoard board({.rate_Hz = rate_Hz});
    firmware::Controller& controller = board.controller();
    const firmware::ParamRow& supervision = firmware::row_of(firmware::Param::host_supervision);
    ASSERT_EQ(controller.write_param(supervision.id, 1), firmware::ParamStatus::kOk);
    SceneBuilder scene;
    scene.plane({0, 0, 1}, -1, {});
    ASSERT_EQ(controller.load_scene(scene.bytes()), firmware::StoreStatus::kOk);
    controller.keep_alive();
    board.tick();
    ASSERT_EQ(controller.request(Command::kHome), 0);
    board.step(.1);
    controller.keep_alive();
    ASSERT_EQ(controller.request(Command::kArm), 0);
    board.tick();
    ASSERT_EQ(controller.mode(), Mode::kArmed);
    const double begin_s = board.time_s();
    double ramp_s = 0, silence_s = 0;
    while (controller.mode() == Mode::kArmed && board.time_s() < begin_s + 5) {
      board.tick();
      if (controller.telemetry().ramp >= 1.0F && ramp_s == 0) ramp_s = board.time_s() - begin_s;
    }
    silence_s = board.time_s() - begin_s;
    figure("ramp, s," + at(rate_Hz), ramp_s, ".2");
    figure("a host's silence until the fault, s," + at(rate_Hz), silence_s, "link_timeout");
    EXPECT_NEAR(ramp_s, .2, 2 / rate_Hz);
    EXPECT_EQ(controller.fault(), firmware::Fault::host_lost);
    const float timeout_s = firmware::row_of(firmware::Param::link_timeout).initial;
    EXPECT_NEAR(silence_s, static_cast<double>(timeout_s), 3 / rate_Hz);
  }
}

// Presses, slides and releases over unlike solids: what the hand gets back is bounded as in energy_test.cpp.
TEST(Rates, NoPathGivesEnergy) {
  for (const double rate_Hz : kEachRate_Hz) {
    Random random(61);
    double most = 0;
    for (int loop = 0; loop < 100; ++loop) {
      const Material material{.static_friction = static_cast<float>(random.uniform(0, .8)),
                              .dynamic_friction = 0};
      SceneBuilder scene;
      scene.sphere(.02, material, {.position_m = {0, 0, -.02}})
          .box({.02, .02, .03}, material, {.position_m = {.02, 0, -.02}})
          .cylinder(.01, .02, material, {.position_m = {-.02, .01, -.02}});
      const SceneImage image = scene.image();
      IdealRun run(image, rate_Hz);
      const Vector3d start(random.uniform(-.03, .03), random.uniform(-.02, .02), .005);
      run.restart(start);
      const double step_m = random.uniform(.02, .3) / rate_Hz;
      run.move(start - Vector3d(0, 0, random.uniform(.006, .02)), step_m);
      for (int slides = 0; slides < 3; ++slides)
        run.move(run.felt().tip_m + random.in_box({.02, .02, .003}), step_m);
      run.move({run.felt().tip_m.x(), run.felt().tip_m.y(), .005}, step_m);
      run.move(start, step_m);
      const double bound_J = kDefaultStiffness_N_m * run.longest_step_m() * run.deepest_m() + 1e-9;
      most = std::max(most, run.work_mean_force_J() / bound_J);
    }
    figure("energy of a loop over K T v x" + at(rate_Hz), most, "< 1");
    EXPECT_LT(most, 1);
  }
}

struct Played {
  double mean_N = 0, most_N = 0, touching = 0;
};
Played play(const std::string& name, double rate_Hz) {
  const std::filesystem::path folder = std::filesystem::path(THIMBLE_SOURCE_DIR) / "scenes" / name;
  const std::vector<std::byte> image = host::compile_scene(folder / (name + ".scene.json")).image;
  Played played;
  double rows = 0;
  const auto result = board::simulate(image, board::read_hand_path(folder / "stroke.csv"),
                                      {.rate_Hz = rate_Hz}, [&](const board::LogRow& row) {
                                        const double force_N = row.force_N.norm();
                                        played.mean_N += force_N;
                                        played.most_N = std::max(played.most_N, force_N);
                                        played.touching += row.contacts > 0 ? 1 : 0;
                                        ++rows;
                                      });
  EXPECT_EQ(result.status, board::SimulationStatus::kOk) << name << at(rate_Hz) << ": " << result.detail;
  played.mean_N /= rows;
  played.touching /= rows;
  return played;
}

TEST(Rates, DemonstrationsFeelTheSame) {
  for (const char* name : {"asteroid", "blocks", "buttons", "ring", "textures"}) {
    const Played usual = play(name, 4000);
    for (const double rate_Hz : kFastRates_Hz) {
      const Played now = play(name, rate_Hz);
      figure(std::string(name) + at(rate_Hz) + ": mean force over that at 4 kHz", now.mean_N / usual.mean_N,
             ".98 to 1.02");
      figure("the most", now.most_N / usual.most_N, ".9 to 1.1");
      figure("ticks in contact", now.touching - usual.touching, "-.002 to .002");
      EXPECT_NEAR(now.mean_N, usual.mean_N, .02 * usual.mean_N);
      EXPECT_NEAR(now.most_N / usual.most_N, 1, .1);
      EXPECT_NEAR(now.touching, usual.touching, .002);
    }
  }
}

}  // namespace
}  // namespace thimble::test
