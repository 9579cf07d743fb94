// The guarded move on the simulated arm: it stops at the right position, keeps its limits, and measures
// correctly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "board/sim/sim_probe.h"
#include "firmware/sources/guarded_move_link.h"
#include "tests/closed_loop/scan/specimens.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using board::SimBoard;
using board::SimProbe;
using board::Vector3d;
using firmware::Fault;
using firmware::Mode;

constexpr double kSurface_m = -.005;

link::MoveOrder order_to(const Vector3d& target_m, float speed_m_s, float force_limit_N,
                         bool come_back = true) {
  link::MoveOrder order;
  order.come_back = come_back;
  order.target_x_m = static_cast<float>(target_m.x());
  order.target_y_m = static_cast<float>(target_m.y());
  order.target_z_m = static_cast<float>(target_m.z());
  order.speed_m_s = speed_m_s;
  order.force_limit_N = force_limit_N;
  return order;
}

board::SimBoardOptions over(double stiffness_N_m, const char* variant = "premium-1.5") {
  return {.variant = variant,
          .specimen = specimen_of(kSurface_m, [=](double, double) { return stiffness_N_m; })};
}

// Above the specimen, holding.
void settle(SimProbe& probe) {
  const auto moved = probe.move(order_to({0, 0, 0}, .05F, 1.0F, false));
  ASSERT_EQ(moved.state.end, link::MoveEnd::kTargetReached);
}

// Starts a move and looks at every tick of it, as long as it is under way.
struct Watched {
  double specimen_N = 0;   // the most that the specimen felt
  double commanded_N = 0;  // the most that the arm was asked for
  double speed_m_s = 0;    // the fastest of the tip
};
Watched watch(SimProbe& probe, const link::MoveOrder& order) {
  SimBoard& board = probe.board();
  EXPECT_EQ(board.controller().request_move(firmware::from_link(order)), 0);
  Watched seen;
  do {
    board.controller().keep_alive();
    board.tick();
    const Vector3d tip_m = board.plant(0).tip_m();
    const Vector3d velocity_m_s = board.plant(0).tip_velocity_m_s();
    if (const auto& specimen = board.options().specimen)
      seen.specimen_N = std::max(seen.specimen_N, specimen->force_N(tip_m, velocity_m_s).norm());
    seen.commanded_N =
        std::max(seen.commanded_N, static_cast<double>(board.controller().telemetry().arm[0].force_N.norm()));
    seen.speed_m_s = std::max(seen.speed_m_s, velocity_m_s.norm());
  } while (board.controller().move_results() == nullptr);
  return seen;
}

// Under way, deep in the specimen and not yet at the limit.
void start_into(SimProbe& probe) {
  settle(probe);
  SimBoard& board = probe.board();
  ASSERT_EQ(board.controller().request_move(firmware::from_link(order_to({0, 0, -.02}, .02F, 2.5F))), 0);
  for (int k = 0; k < 4000 && board.plant(0).tip_m().z() > kSurface_m - .002; ++k) {
    board.controller().keep_alive();
    board.tick();
  }
  ASSERT_TRUE(board.controller().telemetry().moves_itself);
  ASSERT_EQ(board.controller().mode(), Mode::kArmed);
}

TEST(GuardedMove, StopsAtTheForceLimitAndGoesBack) {
  for (const char* variant : {"premium-1.5", "premium-1.5-frictionless", "wooden"}) {
    for (const double stiffness : {200., 500., 1000., 3000.}) {
      SimProbe probe(over(stiffness, variant), free_space());
      settle(probe);
      constexpr double kLimit_N = 1.5;
      constexpr float kSpeed_m_s = .02F;
      const Watched seen = watch(probe, order_to({0, 0, -.02}, kSpeed_m_s, kLimit_N));
      const link::MoveState state = probe.board().controller().move_state();
      const std::string who =
          std::string(variant) + ", " + std::to_string(static_cast<int>(stiffness)) + " N/m: ";
      figure(who + "force on the specimen, N", seen.specimen_N, "1.5 +- 0.2");
      figure(who + "commanded force, N", seen.commanded_N, "<= 2, the limit and its margin");
      figure(who + "tip speed, m/s", seen.speed_m_s, "<= 0.04, the way back begins with a spring");
      figure(who + "tip where it stopped, by the arm, off the truth, um",
             1e6 * (kSurface_m - seen.specimen_N / stiffness - static_cast<double>(state.turn_z_m)),
             "|.| <= 150");
      EXPECT_EQ(state.end, link::MoveEnd::kForceReached);
      EXPECT_NEAR(seen.specimen_N, kLimit_N, .2);
      EXPECT_LE(seen.commanded_N, kLimit_N + .5 + 1e-3);
      EXPECT_LE(seen.speed_m_s, .04);
      EXPECT_NEAR(state.turn_z_m, kSurface_m - seen.specimen_N / stiffness, 150e-6);
      EXPECT_EQ(state.phase, link::MovePhase::kHolding);
      EXPECT_LT(probe.board().plant(0).tip_m().norm(), 1e-3) << "it went back to where it began";
    }
  }
}

TEST(GuardedMove, ArrivesInFreeSpaceAndHolds) {
  SimProbe probe({}, free_space());
  settle(probe);
  const Watched seen = watch(probe, order_to({.03, .02, .01}, .05F, 1.0F, false));
  const Vector3d tip_m = probe.board().plant(0).tip_m();
  figure("speed of a move at 0.05 m/s, m/s", seen.speed_m_s, "<= 0.055");
  figure("off the target, mm", 1e3 * (tip_m - Vector3d(.03, .02, .01)).norm(), "<= 0.5");
  EXPECT_EQ(probe.board().controller().move_state().end, link::MoveEnd::kTargetReached);
  EXPECT_LE(seen.speed_m_s, .055);
  EXPECT_LE((tip_m - Vector3d(.03, .02, .01)).norm(), 5e-4);
  for (int k = 0; k < 4000; ++k) {
    probe.board().controller().keep_alive();
    probe.board().tick();
  }
  EXPECT_LE((probe.board().plant(0).tip_m() - tip_m).norm(), 2e-4) << "it holds";
  ASSERT_EQ(probe.board().controller().request(firmware::Command::kEndMove), 0);
  probe.board().tick();
  EXPECT_FALSE(probe.board().controller().telemetry().moves_itself);
  EXPECT_EQ(probe.board().controller().mode(), Mode::kArmed) << "the scene is rendered again";
  EXPECT_LT(probe.board().controller().telemetry().ramp, .01F);
}

// A move feels nothing of the scene, so it may end inside one of its solids. The solid does not push the tip out: it is met from outside,
// as after arming. With the god object left on the surface the tip of the Premium reached 1.2 m/s, and flew 0.26 m.
TEST(GuardedMove, ItsEndInsideASolidOfTheSceneThrowsNothing) {
  for (const char* variant : {"premium-1.5", "wooden"}) {
    SceneBuilder scene;
    scene.plane({0, 0, 1}, kSurface_m, {});
    SimProbe probe({.variant = variant, .rate_Hz = 1000}, scene.bytes());
    (void)probe.move(order_to({.01, 0, kSurface_m - .03}, .05F, 3.0F, false));
    SimBoard& board = probe.board();
    const Vector3d tip_m = board.plant(0).tip_m();
    EXPECT_LT(tip_m.z(), kSurface_m - .025);
    ASSERT_EQ(board.controller().request(firmware::Command::kEndMove), 0);
    double speed_m_s = 0;
    for (int k = 0; k < 1000; ++k) {
      board.controller().keep_alive();
      board.tick();
      speed_m_s = std::max(speed_m_s, board.plant(0).tip_velocity_m_s().norm());
    }
    figure(std::string(variant) + ": speed after the end of a move, m/s", speed_m_s, "<= 0.1");
    EXPECT_LE(speed_m_s, .1);
    EXPECT_EQ(board.controller().fault(), Fault::kNone);
    EXPECT_LE((board.plant(0).tip_m() - tip_m).norm(), .01);
  }
}

// The contact force by the arm against the truth: as commanded, with the model's friction taken off, and as
// the mean of the ways in and out.
TEST(GuardedMove, MeasuresTheContactForce) {
  constexpr double kStiffness_N_m = 500;
  for (const char* variant : {"premium-1.5", "premium-1.5-frictionless", "wooden"}) {
    SimProbe probe(over(kStiffness_N_m, variant), free_space());
    settle(probe);
    const auto result = probe.move(order_to({0, 0, -.02}, .02F, 1.5F));
    const auto friction_N = static_cast<double>(result.state.friction_N);
    std::array<double, 2> sum_N{}, raw2{}, model2{};
    std::array<int, 2> count{};
    for (const link::MoveSample& s : result.samples) {
      const double true_N = kStiffness_N_m * (kSurface_m - static_cast<double>(s.tip_z_m));
      if (true_N < .3 || true_N > 1.3) continue;
      const std::size_t way = s.phase == link::MovePhase::kGoing ? 0 : 1;
      const double model_N = static_cast<double>(s.force_N) - true_N;
      const double raw_N = model_N + (way == 0 ? friction_N : -friction_N);
      sum_N.at(way) += model_N;
      raw2.at(way) += raw_N * raw_N;
      model2.at(way) += model_N * model_N;
      ++count.at(way);
    }
    ASSERT_GT(std::min(count[0], count[1]), 5);
    const double raw_rms_N = std::sqrt((raw2[0] + raw2[1]) / (count[0] + count[1]));
    const double model_rms_N = std::sqrt((model2[0] + model2[1]) / (count[0] + count[1]));
    const double mean_N = (sum_N[0] / count[0] + sum_N[1] / count[1]) / 2;
    figure(std::string(variant) + ": force as commanded off the truth, RMS, N", raw_rms_N, "reported");
    figure(std::string(variant) + ": with the model's friction off, RMS, N", model_rms_N, "<= 0.08");
    figure(std::string(variant) + ": mean of in and out off the truth, N", mean_N, "|.| <= 0.02");
    EXPECT_LE(model_rms_N, .08);
    EXPECT_LE(std::abs(mean_N), .02);
  }
}

// What must end a move ends it, brakes the arm and leaves it without current.
struct End {
  const char* what;
  void (*act)(SimBoard&);
  Mode mode;
  Fault fault;
  bool alive = true;
};

TEST(GuardedMove, EveryStopStopsIt) {
  constexpr End kEnds[] = {
      {"host lost", [](SimBoard&) {}, Mode::kFaulted, Fault::host_lost, false},
      {"e-stop", [](SimBoard& b) { b.set_e_stop(true); }, Mode::kFaulted, Fault::e_stop},
      {"dead-man released", [](SimBoard& b) { b.set_dead_man(false); }, Mode::kReady, Fault::kNone},
      {"disarm", [](SimBoard& b) { (void)b.controller().request(firmware::Command::kDisarm); }, Mode::kReady,
       Fault::kNone},
      {"stop over the link", [](SimBoard& b) { (void)b.controller().request(firmware::Command::kStop); },
       Mode::kFaulted, Fault::host_stop},
      {"pushed aside",
       [](SimBoard& b) {
         b.plant(0).push({3, 0, 0});
       },
       Mode::kReady, Fault::kNone},
      {"pushed on",
       [](SimBoard& b) {
         b.plant(0).push({0, 0, -8});
       },
       Mode::kReady, Fault::kNone},
  };
  for (const End& end : kEnds) {
    SimProbe probe(over(500), free_space());
    start_into(probe);
    SimBoard& board = probe.board();
    end.act(board);
    int until_stop = 0;
    while (board.controller().mode() == Mode::kArmed && until_stop < 8000) {
      if (end.alive) board.controller().keep_alive();
      board.tick();
      ++until_stop;
    }
    figure(std::string(end.what) + ": ticks until the motors only brake", until_stop,
           end.fault == Fault::host_lost ? "<= 2002" : "<= 400");
    EXPECT_LE(until_stop, end.fault == Fault::host_lost ? 2002 : 400) << end.what;
    board.plant(0).push(Vector3d::Zero());
    board.step(.5);
    EXPECT_EQ(board.controller().mode(), end.mode) << end.what;
    EXPECT_EQ(board.controller().fault(), end.fault) << end.what;
    EXPECT_FALSE(board.controller().telemetry().moves_itself) << end.what;
    for (const board::Motor& motor : board.plant(0).motors()) EXPECT_EQ(motor.current_A, 0) << end.what;
    const auto state_end = board.controller().move_state().end;
    EXPECT_TRUE(state_end == link::MoveEnd::kStopped || state_end == link::MoveEnd::kBlocked) << end.what;
  }
}

// Neither the force along the line nor that across it reaches the limit by itself where the surface leans by about 45 degrees.
TEST(GuardedMove, EndsOnALeaningSurface) {
  double longest_s = 0;
  for (const double lean_deg : {35.0, 45.0, 50.0, 55.0, 60.0}) {
    for (const double friction : {0.0, 0.3}) {
      const double lean = lean_deg * M_PI / 180.0;
      board::SpecimenMap map;
      map.u = {std::cos(lean), 0.0, std::sin(lean)};
      map.origin_m = Vector3d(0.0, 0.0, kSurface_m) - 0.05 * map.u - 0.05 * map.v;
      map.cell_m = 0.002;
      map.columns = map.rows = 51;
      map.stiffness_N_m.assign(map.columns * map.rows, 600.0);
      map.static_friction = map.dynamic_friction = friction;
      SimProbe probe(
          {.variant = "premium-1.5", .specimen = std::make_shared<const board::Specimen>(std::move(map))},
          free_space());
      settle(probe);
      SimBoard& board = probe.board();
      const double begun_s = board.time_s();
      ASSERT_EQ(board.controller().request_move(firmware::from_link(order_to({0, 0, -.03}, .012F, 1.5F))), 0);
      for (int tick = 0; tick < 40'000 && (tick == 0 || board.controller().move_results() == nullptr);
           ++tick) {
        board.controller().keep_alive();
        board.tick();
      }
      ASSERT_NE(board.controller().move_results(), nullptr) << lean_deg << " " << friction;
      longest_s = std::max(longest_s, board.time_s() - begun_s);
      EXPECT_NE(board.controller().move_state().end, link::MoveEnd::kTargetReached)
          << lean_deg << " " << friction;
    }
  }
  figure("a move against a leaning surface: longest, s", longest_s, "< 5");
  EXPECT_LT(longest_s, 5.0);
}

}  // namespace
}  // namespace thimble::test
