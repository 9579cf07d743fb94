// The scenes with moving objects along their strokes, through the firmware and the simulated arms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

struct Body {
  Vector3d at_m;
  Eigen::Quaterniond rotation;
  Vector3d velocity_m_s;
};

struct Moment {
  double time_s = 0;
  std::vector<Vector3d> tip_m;
  std::vector<Vector3d> force_N;
  std::vector<Body> bodies;
};

// From where the path begins.
std::vector<Moment> play(const std::string& file, const std::string& path_of) {
  const fs::path scenes = fs::path(THIMBLE_SOURCE_DIR) / "scenes";
  const std::vector<std::byte> image = host::compile_scene(scenes / file).image;
  const std::vector<board::PathPoint> points = board::read_hand_path(scenes / path_of);
  std::map<int, std::vector<board::PathPoint>> arms;
  for (const board::PathPoint& point : points) arms[point.arm].push_back(point);
  board::SimBoardOptions options;
  options.arm_count = static_cast<std::uint8_t>(arms.size());
  options.slot_bytes = image.size() + 4096;
  board::SimBoard board(options);
  firmware::Controller& controller = board.controller();
  double end_s = 0;
  for (const auto& [arm, path] : arms) {
    board.follow(static_cast<std::size_t>(arm), board::HandPath(path));
    end_s = std::max(end_s, path.back().time_s);
  }
  EXPECT_EQ(controller.load_scene(image), firmware::StoreStatus::kOk);
  const auto until = [&](const std::function<bool()>& condition) {
    for (int tick = 0; tick < 80000 && !condition(); ++tick) {
      controller.keep_alive();
      board.tick();
    }
    return condition();
  };
  controller.keep_alive();
  board.tick();
  EXPECT_EQ(controller.request(firmware::Command::kHome), 0);
  EXPECT_TRUE(until([&] {
    bool waits = controller.mode() == firmware::Mode::kReady;
    for (const auto& [arm, path] : arms) waits = waits && board.hand_waits(static_cast<std::size_t>(arm));
    return waits;
  }));
  EXPECT_EQ(controller.request(firmware::Command::kArm), 0);
  EXPECT_TRUE(until(
      [&] { return controller.mode() == firmware::Mode::kArmed && controller.telemetry().ramp >= 1.0F; }));
  std::vector<Moment> moments;
  while (moments.size() < static_cast<std::size_t>(end_s * 4000)) {
    controller.keep_alive();
    board.tick();
    Moment moment;
    moment.time_s = static_cast<double>(moments.size()) / 4000;
    for (std::size_t arm = 0; arm < arms.size(); ++arm) {
      moment.tip_m.push_back(board.plant(arm).tip_m());
      moment.force_N.push_back(controller.telemetry().arm[arm].rendered_N.cast<double>());
    }
    for (const control::BodyState& body : controller.renderer().bodies())
      moment.bodies.push_back(
          {body.position_m.cast<double>(), body.rotation.cast<double>(), body.velocity_m_s.cast<double>()});
    moments.push_back(moment);
  }
  EXPECT_EQ(controller.fault(), firmware::Fault::kNone);
  return moments;
}

double hardest_N(const std::vector<Moment>& moments) {
  double most = 0;
  for (const Moment& m : moments) {
    for (const Vector3d& force : m.force_N) most = std::max(most, force.norm());
  }
  return most;
}

const Moment& at(const std::vector<Moment>& moments, double time_s) {
  return moments.at(static_cast<std::size_t>(time_s * 4000));
}

TEST(Scenes, BlocksAreStackedTakenBackAndThrown) {
  const std::vector<Moment> moments = play("blocks/blocks.scene.json", "blocks/stroke.csv");
  // Lifted and carried (2.7 s), standing on the other one with both hands away (4.2 s), thrown (after 5.6 s).
  const Vector3d carried = at(moments, 2.6).bodies[0].at_m;
  const Vector3d stacked = at(moments, 4.1).bodies[0].at_m;
  double highest = -1;
  bool falls = false;
  double free_from = 0;
  double free_to = 0;
  for (const Moment& m : moments) {
    if (m.time_s < 5.6) continue;
    const Body& block = m.bodies[0];
    highest = std::max(highest, block.at_m.z());
    if (m.force_N[0].norm() == 0 && m.force_N[1].norm() == 0 && !falls && block.at_m.z() > -.02) {
      falls = true;
      free_from = m.time_s;
    }
    if (falls && free_to == 0 && block.at_m.z() < -.0345) free_to = m.time_s;
  }
  const Body let_go = at(moments, free_from).bodies[0];
  const double t = .6 * (free_to - free_from);
  const double expected = let_go.at_m.z() + let_go.velocity_m_s.z() * t - .5 * 9.81 * t * t;
  const double error = at(moments, free_from + t).bodies[0].at_m.z() - expected;
  figure("blocks: near block carried at, mm", 1e3 * carried.z(), "> 15");
  figure("blocks: near block stands on the far one at, mm", 1e3 * stacked.z(), "-5");
  figure("blocks: far block has moved, mm",
         1e3 * (at(moments, 4.1).bodies[1].at_m - Vector3d(0, .03, -.035)).norm(), "< 3");
  figure("blocks: thrown up to, mm", 1e3 * highest, "> 25");
  figure("blocks: in flight for, s", free_to - free_from, "> 0.08");
  figure("blocks: off its parabola by, mm", 1e3 * error, "< 0.3");
  figure("blocks: near block lies at the end at z, mm", 1e3 * moments.back().bodies[0].at_m.z(), "-35");
  figure("blocks: hardest force, N", hardest_N(moments), "1 to 6");
  EXPECT_GT(carried.z(), .015);
  EXPECT_NEAR(stacked.z(), -.005, 2e-4);
  EXPECT_LT(at(moments, 4.1).bodies[0].velocity_m_s.norm(), 1e-3);
  EXPECT_LT((at(moments, 4.1).bodies[1].at_m - Vector3d(0, .03, -.035)).norm(), 3e-3);
  EXPECT_GT(highest, .025);
  EXPECT_GT(free_to - free_from, .08);
  EXPECT_LT(std::abs(error), 3e-4);
  EXPECT_NEAR(moments.back().bodies[0].at_m.z(), -.035, 2e-4);
  EXPECT_LT(hardest_N(moments), 6);
}

TEST(Scenes, ABlockIsDribbled) {
  const std::vector<Moment> moments = play("blocks/dribble.scene.json", "blocks/dribble.stroke.csv");
  struct Bounce {
    double time_s, down_m_s, up_m_s, pushed_N_s;  // pushed: by the finger, since the bounce before
  };
  std::vector<Bounce> bounces;
  double pushed_N_s = 0;
  for (std::size_t i = 1; i < moments.size(); ++i) {
    const double before = moments[i - 1].bodies[0].velocity_m_s.z();
    const double after = moments[i].bodies[0].velocity_m_s.z();
    pushed_N_s += moments[i].force_N[0].z() / 4000;
    if (moments[i].time_s < 3.3 || moments[i].time_s > 4.9 || before > -.3 || after < 0) continue;
    bounces.push_back({moments[i].time_s, -before, after, pushed_N_s});
    pushed_N_s = 0;
  }
  ASSERT_GT(bounces.size(), 8U);
  // Between one bounce and the next the finger, the block's weight and the table add up to nothing.
  double worst = 0;
  double restitution = 0;
  double slowest = 9;
  double fastest = 0;
  for (std::size_t i = 1; i < bounces.size(); ++i) {
    const Bounce& last = bounces[i - 1];
    const Bounce& now = bounces[i];
    const double gained = .1 * (now.down_m_s + last.up_m_s);
    const double given = now.pushed_N_s + .1 * 9.81 * (now.time_s - last.time_s);
    worst = std::max(worst, std::abs(given / gained - 1));
    EXPECT_GT(now.pushed_N_s, .01) << "a bounce without the finger at " << now.time_s << " s";
    restitution += now.up_m_s / now.down_m_s / static_cast<double>(bounces.size() - 1);
    slowest = std::min(slowest, now.down_m_s);
    fastest = std::max(fastest, now.down_m_s);
  }
  figure("dribble: bounces in 1.6 s", static_cast<double>(bounces.size()), "11 or 12, at 0.14 s");
  figure("dribble: slowest on the table, m/s", slowest, "within 3 % of the fastest");
  figure("dribble: fastest, m/s", fastest, "");
  figure("dribble: restitution", restitution, "0.85");
  figure("dribble: finger, weight and table differ by, %", 100 * worst, "< 1");
  EXPECT_NEAR(static_cast<double>(bounces.size()), 1.6 / .14, 1);
  EXPECT_GT(slowest, .97 * fastest);
  EXPECT_NEAR(restitution, .85, .01);
  EXPECT_LT(worst, .01);
  EXPECT_LT(hardest_N(moments), 8);
}

TEST(Scenes, ABlockIsTurnedAndATallOneTipped) {
  const std::vector<Moment> moments = play("blocks-6dof/blocks-6dof.scene.json", "blocks-6dof/stroke.csv");
  const Body held = at(moments, 2.0).bodies[0];
  const Body turned = at(moments, 4.0).bodies[0];
  const Vector3d side = turned.rotation * Vector3d::UnitX();
  const double yaw = std::atan2(side.y(), side.x()) * 180 / M_PI;
  const Vector3d up = moments.back().bodies[1].rotation * Vector3d::UnitZ();
  const double tipped = std::acos(std::clamp(up.z(), -1.0, 1.0)) * 180 / M_PI;
  figure("blocks-6dof: block held at, mm", 1e3 * held.at_m.z(), "> -15");
  figure("blocks-6dof: turned about the vertical, degrees", yaw, "40 +- 6");
  figure("blocks-6dof: block put down at, mm", 1e3 * turned.at_m.z(), "-35");
  figure("blocks-6dof: tall block leans at the end, degrees", tipped, "90: it lies");
  figure("blocks-6dof: hardest force, N", hardest_N(moments), "< 6");
  EXPECT_GT(held.at_m.z(), -.015);
  EXPECT_NEAR(yaw, 40, 6);
  EXPECT_NEAR(turned.at_m.z(), -.035, 3e-4);
  EXPECT_NEAR(tipped, 90, 1);
  EXPECT_LT(hardest_N(moments), 6);
}

TEST(Scenes, PucksOfMulty3KnockEachOther) {
  const std::vector<Moment> moments = play("multy3/multy3.scene.json", "multy3/stroke.csv");
  std::vector<double> fastest(3, 0.0);
  double off_plane = 0;
  std::vector<double> felt(3, 0.0);
  for (const Moment& m : moments) {
    for (std::size_t i = 0; i < 3; ++i) {
      fastest[i] = std::max(fastest[i], m.bodies[i].velocity_m_s.norm());
      off_plane = std::max(off_plane, std::abs(m.bodies[i].at_m.z() + .03));
    }
    felt[0] = std::max(felt[0], m.force_N[0].norm());
  }
  for (std::size_t i = 0; i < 3; ++i)
    figure("multy3: fastest of puck " + std::to_string(i) + ", m/s", fastest[i], "> 0.05");
  figure("multy3: pucks leave their plane by, um", 1e6 * off_plane, "< 0.01");
  figure("multy3: hardest force, N", felt[0], "0.3 to 6");
  for (const double f : fastest) EXPECT_GT(f, .05);
  EXPECT_LT(off_plane, 1e-8);
  // A knock: in one tick two pucks that come together both change their speed, and part.
  const std::array<double, 3> mass_kg{.05, .15, .45};
  int knocks = 0;
  double restitution_off = 0;
  double momentum_lost = 0;  // share of what one gave the other
  for (std::size_t k = 1; k < moments.size(); ++k) {
    const auto& before = moments[k - 1].bodies;
    const auto& after = moments[k].bodies;
    for (const auto& [i, j] : {std::pair(0U, 1U), std::pair(0U, 2U), std::pair(1U, 2U)}) {
      const Vector3d n = (before[j].at_m - before[i].at_m).normalized();
      const double closing = (before[i].velocity_m_s - before[j].velocity_m_s).dot(n);
      const double parting = (after[j].velocity_m_s - after[i].velocity_m_s).dot(n);
      const Vector3d given = mass_kg[i] * (before[i].velocity_m_s - after[i].velocity_m_s);
      const Vector3d taken = mass_kg[j] * (after[j].velocity_m_s - before[j].velocity_m_s);
      if (closing < .03 || parting <= 0 || given.norm() < 1e-3 || taken.norm() < 1e-3) continue;
      ++knocks;
      restitution_off = std::max(restitution_off, std::abs(parting / closing - .8));
      momentum_lost = std::max(momentum_lost, (given - taken).norm() / taken.norm());
    }
  }
  figure("multy3: knocks", knocks, "at least 3");
  figure("multy3: restitution of a knock off 0.8 by, worst", restitution_off, "< 0.005");
  figure("multy3: momentum lost in a knock, worst share", momentum_lost, "< 0.01");
  EXPECT_GE(knocks, 3);
  EXPECT_LT(restitution_off, .005);
  EXPECT_LT(momentum_lost, .01);
  // Pushed alike, each by its own stroke: what it takes tells the masses apart.
  std::array<double, 3> impulse_N_s{};
  for (std::size_t puck = 0; puck < 3; ++puck) {
    const double from_s = .9 + 2.7 * static_cast<double>(puck);
    for (double t = from_s; t < from_s + .7; t += 2.5e-4)
      impulse_N_s[puck] += 2.5e-4 * at(moments, t).force_N[0].norm();
    figure("multy3: push of puck " + std::to_string(puck) + ", N s", impulse_N_s[puck],
           "more for the heavier one");
  }
  EXPECT_GT(impulse_N_s[1], 1.1 * impulse_N_s[0]);
  EXPECT_GT(impulse_N_s[2], 2 * impulse_N_s[1]);
  EXPECT_GT(felt[0], .3);
  EXPECT_LT(felt[0], 6);
}

TEST(Scenes, TheAsteroidIsPushedAway) {
  const std::vector<Moment> moments = play("asteroid/pushed.scene.json", "asteroid/stroke.csv");
  double away = 0;
  double turned = 0;
  for (const Moment& m : moments) {
    away = std::max(away, (m.bodies[0].at_m - Vector3d(0, 0, -.055)).norm());
    turned = std::max(turned, Eigen::AngleAxisd(m.bodies[0].rotation).angle());
  }
  figure("asteroid, pushed by at most, mm", 1e3 * away, "> 3");
  figure("asteroid, turned by at most, degrees", turned * 180 / M_PI, "> 5");
  figure("asteroid, pushed: hardest force, N", hardest_N(moments), "0.1 to 6");
  EXPECT_GT(away, 3e-3);
  EXPECT_GT(turned, .08);
  EXPECT_GT(hardest_N(moments), .1);
}

}  // namespace
}  // namespace thimble::test
