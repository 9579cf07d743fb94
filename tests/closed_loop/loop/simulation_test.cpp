// The engine of `thimble simulate`.
#include "board/sim/simulation.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::LogRow;
using board::PathPoint;
using board::SimulationOptions;
using board::SimulationResult;
using board::SimulationStatus;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::byte> floor_scene(float stiffness_N_m = 1000, float damping_N_s_m = 0) {
  SceneBuilder scene;
  scene.plane({0, 0, 1}, 0.0, {.stiffness_N_m = stiffness_N_m, .damping_N_s_m = damping_N_s_m});
  return scene.bytes();
}

struct Log {
  SimulationResult result;
  std::vector<LogRow> rows;
};

Log run(const std::vector<std::byte>& image, const std::vector<PathPoint>& path,
        const SimulationOptions& options) {
  Log log;
  log.result = board::simulate(image, path, options, [&](const LogRow& row) { log.rows.push_back(row); });
  return log;
}

const std::vector<PathPoint> kPress{
    {1.0, {0, 0, .005}}, {1.2, {0, 0, -.003}}, {1.3, {0, 0, -.003}}, {1.5, {0, 0, .005}}};

TEST(Simulate, OneRowATickUpToAndIncludingTheLast) {
  for (const double rate : {1000.0, 4000.0, 10000.0}) {
    const Log log = run(floor_scene(), kPress, {.ideal = true, .rate_Hz = rate});
    ASSERT_EQ(log.result.status, SimulationStatus::kOk);
    ASSERT_EQ(log.rows.size(), static_cast<std::size_t>(.5 * rate) + 1);
    EXPECT_EQ(log.result.ticks, log.rows.size());
    EXPECT_EQ(log.rows.front().time_s, 1.0);
    EXPECT_NEAR(log.rows.back().time_s, 1.5, 1e-9);
    for (std::size_t k = 0; k < log.rows.size(); ++k)
      ASSERT_DOUBLE_EQ(log.rows[k].time_s, 1.0 + static_cast<double>(k) / rate);
  }
}

TEST(Simulate, IdealIsThePathAndTheSpring) {
  const Log log = run(floor_scene(), kPress, {.ideal = true});
  double position = 0, force = 0;
  int touching = 0;
  for (const LogRow& row : log.rows) {
    const double t = row.time_s;
    const double z = t < 1.2 ? .005 - .04 * (t - 1.0) : t < 1.3 ? -.003 : -.003 + .04 * (t - 1.3);
    position = std::max(position, std::abs(row.tip_m.z() - z));
    if (z < -1e-6) {
      ++touching;
      force = std::max(force, std::abs(row.force_N.z() - 1000 * -z) / (1000 * -z + 1));
      EXPECT_EQ(row.contacts, 1);
      EXPECT_NEAR(row.proxy_m.z(), 0, 1e-7);
    } else if (z > 1e-6) {
      EXPECT_EQ(row.force_N.norm(), 0);
      EXPECT_EQ(row.contacts, 0);
      EXPECT_EQ(row.proxy_m, row.tip_m);
    }
  }
  figure("tip off the path, m", position, "<= 1e-9");
  figure("force off K d, relative", force, "<= 1e-4");
  EXPECT_LE(position, 1e-9);
  EXPECT_LE(force, 1e-4);
  EXPECT_GT(touching, 900);
}

TEST(Simulate, IdealVelocityIsThePaths) {
  // One-sided damping: going in at 0.04 m/s adds B v; at rest nothing.
  const Log log = run(floor_scene(1000, 10), kPress, {.ideal = true});
  for (const LogRow& row : log.rows) {
    const double depth = -row.tip_m.z();
    if (depth < 1e-4) continue;
    if (row.time_s < 1.1999) {
      EXPECT_NEAR(row.force_N.z(), 1000 * depth + 10 * .04, 1e-3) << row.time_s;
    } else if (row.time_s > 1.2001 && row.time_s < 1.2999) {
      EXPECT_NEAR(row.force_N.z(), 1000 * depth, 1e-3) << row.time_s;
    }
  }
}

TEST(Simulate, ThroughTheArmTheHandMeetsTheFloor) {
  std::vector<PathPoint> path = kPress;
  path.insert(path.begin() + 2, {2.0, {0, 0, -.003}});
  path[3].time_s = 2.1;
  path[4].time_s = 2.3;
  for (const char* arm : {"premium-1.5", "premium-1.5-frictionless", "wooden"}) {
    const Log log = run(floor_scene(1000, 2), path, {.arm = arm, .sensors = {.line_loss = true}});
    ASSERT_EQ(log.result.status, SimulationStatus::kOk) << log.result.detail;
    ASSERT_EQ(log.rows.size(), 1.3 * 4000 + 1);
    // Hand's spring against the wall's: 3 mm shared as 500 : 1000, so 1 mm deep and 1 N. Friction keeps some
    // of it.
    const LogRow& row = log.rows[4000 * 95 / 100];
    figure(std::string(arm) + ": force on a hand that wants to be 3 mm deep, N", row.force_N.z(),
           "1 +- 0.25");
    EXPECT_NEAR(row.force_N.z(), 1.0, .25);
    EXPECT_NEAR(row.tip_m.z(), -.001, 3e-4);
    EXPECT_EQ(row.contacts, 1);
    EXPECT_NEAR(row.proxy_m.z(), 0, 1e-6);
    EXPECT_NEAR(log.rows.front().tip_m.z(), .005, 1e-3);
  }
}

std::array<std::uint64_t, 3> bits(const Eigen::Vector3d& v) {
  return {std::bit_cast<std::uint64_t>(v.x()), std::bit_cast<std::uint64_t>(v.y()),
          std::bit_cast<std::uint64_t>(v.z())};
}

TEST(Simulate, DeterministicToTheBitAndFasterThanRealTime) {
  const auto begin = std::chrono::steady_clock::now();
  const Log a = run(floor_scene(1000, 2), kPress, {});
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Log b = run(floor_scene(1000, 2), kPress, {});
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t k = 0; k < a.rows.size(); ++k) {
    ASSERT_EQ(bits(a.rows[k].tip_m), bits(b.rows[k].tip_m)) << k;
    ASSERT_EQ(bits(a.rows[k].force_N), bits(b.rows[k].force_N)) << k;
  }
  const Log other = run(floor_scene(1000, 2), kPress, {.seed = 2});
  EXPECT_NE(a.rows.back().tip_m, other.rows.back().tip_m);
  figure("wall time for 0.5 s of path, homing and arming, s", wall_s, "reported");
}

TEST(Simulate, TwoArmsShareTheScene) {
  std::vector<PathPoint> path;
  for (const int arm : {0, 1}) {
    const double x = arm == 0 ? -.1 : .1;
    path.push_back({0, {x, 0, .005}, arm});
    path.push_back({.2 + .1 * arm, {x, 0, -.004}, arm});
    path.push_back({.6, {x, 0, -.004}, arm});
  }
  for (const bool ideal : {true, false}) {
    const Log log = run(floor_scene(1000, 2), path, {.ideal = ideal});
    ASSERT_EQ(log.result.status, SimulationStatus::kOk) << log.result.detail;
    ASSERT_EQ(log.rows.size(), 2 * (.6 * 4000 + 1));
    for (std::size_t k = 0; k < log.rows.size(); ++k) ASSERT_EQ(log.rows[k].arm, static_cast<int>(k % 2));
    for (std::size_t k = log.rows.size() - 2; k < log.rows.size(); ++k) {
      EXPECT_GT(log.rows[k].force_N.z(), .7) << "arm " << log.rows[k].arm;
      EXPECT_NEAR(log.rows[k].tip_m.x(), log.rows[k].arm == 0 ? -.1 : .1, 1e-3);
    }
  }
}

TEST(Simulate, AHeldForceIsLimitedOnlyOffIdeal) {
  const std::vector<PathPoint> path{{0, {0, 0, .001}}, {.3, {0, 0, -.03}}, {.8, {0, 0, -.03}}};
  const Log ideal = run(floor_scene(), path, {.ideal = true});
  EXPECT_NEAR(ideal.rows.back().force_N.z(), 30, 1e-2);
  const Log arm = run(floor_scene(), path, {});
  ASSERT_EQ(arm.result.status, SimulationStatus::kOk) << arm.result.detail;
  for (const LogRow& row : arm.rows) EXPECT_LE(row.force_N.norm(), 8.501);
}

TEST(Simulate, BadInputIsNamed) {
  const std::vector<std::byte> image = floor_scene();
  const auto status = [&](const std::vector<std::byte>& bytes, const std::vector<PathPoint>& path,
                          SimulationOptions options) {
    for (const bool ideal : {true, false}) {
      options.ideal = ideal;
      const Log log = run(bytes, path, options);
      EXPECT_TRUE(log.rows.empty());
      EXPECT_FALSE(log.result.detail.empty());
      if (ideal) continue;
      return log.result.status;
    }
    return SimulationStatus::kOk;
  };
  EXPECT_EQ(status({}, kPress, {}), SimulationStatus::kImageRefused);
  EXPECT_EQ(status(std::vector<std::byte>(100), kPress, {}), SimulationStatus::kImageRefused);
  EXPECT_EQ(status(image, kPress, {.arm = "robot"}), SimulationStatus::kUnknownArm);
  EXPECT_EQ(status(image, kPress, {.rate_Hz = 99}), SimulationStatus::kBadRate);
  EXPECT_EQ(status(image, kPress, {.rate_Hz = kNan}), SimulationStatus::kBadRate);
  EXPECT_EQ(status(image, {}, {}), SimulationStatus::kBadPath);
  EXPECT_EQ(status(image, {{0, {0, 0, kNan}}}, {}), SimulationStatus::kBadPath);
  EXPECT_EQ(status(image, {{0, {0, 0, 0}}, {0, {0, 0, 0}}}, {}), SimulationStatus::kBadPath);
  EXPECT_EQ(status(image, {{0, {0, 0, 0}, 1}}, {}), SimulationStatus::kBadPath);
  EXPECT_EQ(status(image, {{0, {0, 0, 0}, 2}}, {}), SimulationStatus::kBadPath);
  EXPECT_EQ(run(image, {{0, {0, 0, 1.0}}}, {}).result.status, SimulationStatus::kOutOfReach);
}

}  // namespace
}  // namespace thimble::test
