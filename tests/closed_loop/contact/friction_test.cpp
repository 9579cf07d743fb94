// Friction as in section 3.6 of the paper, on flats where |F_t| and |F_n| need no convention.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;
using scene::FrictionMode;

constexpr double kStatic = 0.6;
constexpr double kDynamic = 0.4;
constexpr double kPress_m = 0.002;

constexpr int kStillTicks = kUnderSanitizers ? 10'000 : 1'000'000;

Material rough(FrictionMode mode, double stiffness_N_m = kDefaultStiffness_N_m) {
  return {.stiffness_N_m = static_cast<float>(stiffness_N_m),
          .static_friction = static_cast<float>(kStatic),
          .dynamic_friction = static_cast<float>(kDynamic),
          .friction_mode = mode};
}

struct Flat {
  std::string name;
  SceneImage image;
};

// Flats with their free side above z = 0.
std::vector<Flat> flats(FrictionMode mode) {
  const Pose lowered = {{0.0, 0.0, -0.01}, Eigen::Quaterniond::Identity()};
  const host::TriangleSoup grid = box_mesh({0.2, 0.2, 0.02}, 17);
  std::vector<Flat> result;
  result.push_back({"plane", SceneBuilder().plane(Vector3d::UnitZ(), 0.0, rough(mode)).image()});
  result.push_back({"box", SceneBuilder().box({0.2, 0.2, 0.02}, rough(mode), lowered).image()});
  result.push_back({"mesh", SceneBuilder().mesh(grid, rough(mode), {}, lowered).image()});
  result.push_back(
      {"shaded mesh",
       SceneBuilder().mesh(grid, rough(mode), {host::MeshSide::kOutside, 40.0}, lowered).image()});
  return result;
}

double ratio(const Felt& felt) { return felt.force_N.head<2>().norm() / felt.force_N.z(); }

TEST(Friction, BreaksAwayAtTheStaticCoefficient) {
  for (const FrictionMode mode : {FrictionMode::StickSlip, FrictionMode::Steady}) {
    for (const Flat& flat : flats(mode)) {
      IdealRun run(flat.image);
      double worst = 0.0;
      for (int direction = 0; direction < 16; ++direction) {
        const Vector3d way(std::cos(0.4 * direction), std::sin(0.4 * direction), 0.0);
        run.restart({0.0, 0.0, 0.001});
        run.move({0.0, 0.0, -kPress_m}, 2.5e-5);
        EXPECT_LE(ratio(run.felt()), 1e-3) << "a straight press must not be pushed sideways";
        double peak = 0.0;
        for (int tick = 1; tick <= 3000; ++tick) {  // 1 um a tick
          run.step(Vector3d(0.0, 0.0, -kPress_m) + 1e-6 * tick * way);
          if (ratio(run.felt()) < peak - 1e-3) break;
          peak = std::max(peak, ratio(run.felt()));
        }
        worst = std::max(worst, std::abs(peak / kStatic - 1.0));
      }
      figure(std::string("breakaway, ") + scene::EnumNameFrictionMode(mode) + ", " + flat.name +
                 ": |peak/mu_s - 1|",
             worst, "0.01");
      EXPECT_LE(worst, 0.01) << flat.name;
    }
  }
}

TEST(Friction, LandsOnTheSurface) {
  Random random(18);
  for (const FrictionMode mode : {FrictionMode::StickSlip, FrictionMode::Steady}) {
    for (const Flat& flat : flats(mode)) {
      IdealRun run(flat.image);
      double worst_N = 0.0;
      double worst_sideways_m = 0.0;
      for (int landing = 0; landing < 500; ++landing) {
        const Vector3d above =
            random.in_box({0.03, 0.03, 0.0}) + Vector3d(0.0, 0.0, random.uniform(1e-5, 0.003));
        const Vector3d below =
            above + random.in_box({0.0005, 0.0005, 0.0}) + Vector3d(0.0, 0.0, -0.001 - above.z());
        run.restart(above);
        const Felt from = run.felt();
        const Felt first = run.step(below);
        const double share = from.tip_m.z() / (from.tip_m.z() - first.tip_m.z());
        const Vector3d met = from.tip_m + share * (first.tip_m - from.tip_m);
        // Sticks where the way of the tip met the surface, unless that is beyond the friction cone.
        if ((met - first.tip_m).head<2>().norm() < 0.99 * kStatic * -first.tip_m.z()) {
          worst_sideways_m = std::max(worst_sideways_m, (first.god_object_m - met).norm());
        }
        worst_N = std::max(worst_N, std::abs(first.force_N.z() + kDefaultStiffness_N_m * first.tip_m.z()));
        for (int tick = 0; tick < 10; ++tick) {
          const Felt& felt = run.step(below + random.in_box({0.0001, 0.0001, 0.0005}));
          worst_N = std::max(worst_N, std::abs(felt.force_N.z() + kDefaultStiffness_N_m * felt.tip_m.z()));
        }
      }
      const std::string what = std::string("landing with friction, ") + scene::EnumNameFrictionMode(mode) +
                               ", " + flat.name + ": ";
      figure(what + "|F_n - K d|, N", worst_N, "4e-4");
      figure(what + "stiction point off where the surface was met, um", 1e6 * worst_sideways_m, "1");
      EXPECT_LE(worst_N, 4e-4) << flat.name;
      EXPECT_LE(worst_sideways_m, 1e-6) << flat.name;
    }
  }
}

TEST(Friction, StickSlipSawsBetweenTheTwoCoefficients) {
  for (const Flat& flat : flats(FrictionMode::StickSlip)) {
    for (const double speed_m_s : {0.02, 0.1, 0.3}) {
      IdealRun run(flat.image);
      run.step({-0.06, 0.01, 0.001});
      run.move({-0.06, 0.01, -kPress_m}, 2.5e-5);
      const double step = speed_m_s / kRate_Hz;
      const double step_ratio = step / kPress_m;  // what one tick adds to the ratio
      int slips = 0;
      double worst_drop = 0.0;
      double highest = 0.0;
      double lowest_peak = 1.0;
      double lowest = 1.0;
      double before = 0.0;
      for (double x = -0.06; x < 0.06; x += step) {
        run.step({x, 0.016 + 0.1 * x, -kPress_m});
        const double now = ratio(run.felt());
        highest = std::max(highest, now);
        if (now < before) {
          ++slips;
          worst_drop = std::max(worst_drop, std::abs(now / kDynamic - 1.0));
          lowest_peak = std::min(lowest_peak, before);
        }
        if (slips > 0) lowest = std::min(lowest, now);
        before = now;
      }
      const std::string what =
          "stick-slip, " + flat.name + " at " + std::to_string(speed_m_s).substr(0, 4) + " m/s: ";
      figure(what + "slips", slips, "> 20");
      figure(what + "|ratio after a slip/mu_d - 1|", worst_drop, "0.01");
      figure(what + "highest ratio", highest, "mu_s = 0.6, 1 %");
      figure(what + "lowest peak", lowest_peak, "mu_s less one tick's travel");
      figure(what + "lowest ratio", lowest, "mu_d = 0.4, 1 %");
      EXPECT_GT(slips, 20);
      EXPECT_LE(worst_drop, 0.01);
      EXPECT_LE(highest, kStatic * 1.01);
      EXPECT_GE(lowest_peak, kStatic * 0.99 - 1.01 * step_ratio);
      EXPECT_GE(lowest, kDynamic * 0.99);
    }
  }
}

TEST(Friction, SteadyStaysAtTheDynamicCoefficientWhileTheTipMoves) {
  for (const Flat& flat : flats(FrictionMode::Steady)) {
    for (const double speed_m_s : {0.02, 0.1, 0.3}) {
      IdealRun run(flat.image);
      run.step({-0.06, 0.01, 0.001});
      run.move({-0.06, 0.01, -kPress_m}, 2.5e-5);
      const double step = speed_m_s / kRate_Hz;
      double low = 1.0;
      double high = 0.0;
      double x = -0.06;
      for (; x < 0.06; x += step) {
        run.step({x, 0.016 + 0.1 * x, -kPress_m - 0.0005 * std::sin(100.0 * x)});
        if (x < -0.055) continue;  // breakaway lies behind
        low = std::min(low, ratio(run.felt()));
        high = std::max(high, ratio(run.felt()));
      }
      const std::string what =
          "steady, " + flat.name + " at " + std::to_string(speed_m_s).substr(0, 4) + " m/s: ";
      figure(what + "lowest |F_t|/F_n", low, "0.398");
      figure(what + "highest |F_t|/F_n", high, "0.402");
      EXPECT_GE(low, kDynamic * 0.995);
      EXPECT_LE(high, kDynamic * 1.005);
    }
  }
}

TEST(Friction, SteadySlidesOnWhereTheSurfaceIsShaded) {
  // Where a coarse mesh is shaded, rest is not the point of the surface that is nearest to the tip.
  constexpr double kHeight_m = 0.0006;
  constexpr double kWave_m = 0.006;
  host::TriangleSoup waves = sheet(0.1, 40);
  for (Vector3d& p : waves.vertices_m) p.z() = kHeight_m * std::cos(2.0 * std::numbers::pi * p.x() / kWave_m);
  IdealRun run(
      SceneBuilder().mesh(waves, rough(FrictionMode::Steady), {host::MeshSide::kBoth, 60.0}).image());
  constexpr double kStep_m = 1e-5;
  run.step({-0.04, 0.003, 0.001});
  run.move({-0.04, 0.003, -kPress_m}, kStep_m);
  run.move({-0.03, 0.003, -kPress_m}, kStep_m);
  Vector3d last = run.felt().god_object_m;
  double farthest_m = 0.0;
  for (double x = -0.03; x < 0.04; x += kStep_m) {
    const Felt& felt = run.step({x, 0.003, -kPress_m});
    farthest_m = std::max(farthest_m, (felt.god_object_m - last).norm());
    last = felt.god_object_m;
  }
  figure("steady, shaded waves: farthest way of the god object in a tick, ways of the tip",
         farthest_m / kStep_m, "< 5: it never lets go");
  EXPECT_LT(farthest_m, 5.0 * kStep_m);
}

TEST(Friction, SteadySticksAgainWhenTheTipStopsOrTurns) {
  for (const Flat& flat : flats(FrictionMode::Steady)) {
    const auto slide = [&](IdealRun& run) {
      run.step({-0.01, 0.01, 0.001});
      run.move({-0.01, 0.01, -kPress_m}, 2.5e-5);
      run.move({0.0, 0.01, -kPress_m}, 2.5e-5);
      EXPECT_NEAR(ratio(run.felt()), kDynamic, 0.005 * kDynamic);
    };
    IdealRun stopped(flat.image);
    slide(stopped);
    const double force_at_stop = stopped.felt().force_N.x();
    for (int tick = 0; tick < 400; ++tick) stopped.step({0.0, 0.01, -kPress_m});
    EXPECT_NEAR(stopped.felt().force_N.x(), force_at_stop, 1e-3);
    double peak = 0.0;
    for (int tick = 1; tick < 2000; ++tick)
      peak = std::max(peak, ratio(stopped.step({1e-6 * tick, 0.01, -kPress_m})));
    figure("steady, " + flat.name + ": peak ratio on moving on after a stop", peak, "mu_s = 0.6, 1 %");
    EXPECT_NEAR(peak, kStatic, 0.01 * kStatic);

    IdealRun turned(flat.image);
    slide(turned);
    // Sticking: the force is a spring to one point until the other side breaks away at mu_s.
    const double start_N = turned.felt().force_N.x();
    double worst_N = 0.0;
    double highest = -1.0;
    for (int tick = 1; tick < 4000; ++tick) {
      const double back_m = 1e-6 * tick;
      turned.step({-back_m, 0.01, -kPress_m});
      const double spring_N = start_N + kDefaultStiffness_N_m * back_m;
      if (spring_N < 0.99 * kStatic * kDefaultStiffness_N_m * kPress_m) {
        worst_N = std::max(worst_N, std::abs(turned.felt().force_N.x() - spring_N));
      }
      highest = std::max(highest, turned.felt().force_N.x() / turned.felt().force_N.z());
    }
    figure("steady, " + flat.name + ": |F_t - spring| after turning, N", worst_N, "2e-3");
    figure("steady, " + flat.name + ": peak ratio on the way back", highest, "mu_s = 0.6, 1 %");
    EXPECT_LE(worst_N, 2e-3);
    EXPECT_NEAR(highest, kStatic, 0.01 * kStatic);
  }
}

struct Still {
  std::string name;
  SceneImage image;
  std::vector<Vector3d> path;  // from free space to where the tip rests
};

std::vector<Still> still_scenes(FrictionMode mode) {
  const Vector3d left_n = Vector3d(1.0, 0.0, 1.0).normalized();
  const Vector3d right_n = Vector3d(-1.0, 0.0, 1.0).normalized();
  const host::TriangleSoup block = box_mesh({0.1, 0.1, 0.02}, 4);
  const Pose lowered = {{0.0, 0.0, -0.01}, Eigen::Quaterniond::Identity()};
  const std::vector<Vector3d> press = {{0.0, 0.0, 0.001}, {0.0, 0.0, -0.002}, {0.0006, 0.0003, -0.002}};
  const std::vector<Vector3d> groove = {{0.0, 0.0, 0.001}, {0.0, 0.0, -0.002}, {0.0002, 0.0006, -0.002}};
  // Over the block's rim at x = 0.05, the god object on the edge between two faces of the knife.
  std::vector<Still> scenes;
  scenes.push_back({"plane", SceneBuilder().plane(Vector3d::UnitZ(), 0.0, rough(mode)).image(), press});
  scenes.push_back(
      {"inner edge of a mesh", SceneBuilder().mesh(block, rough(mode), {}, lowered).image(), press});
  scenes.push_back({"outer edge of a mesh",
                    SceneBuilder().mesh(knife(60.0, 0.03, 0.1, 7), rough(mode)).image(),
                    {{0.0, 0.003, 0.001}, {0.0, 0.003, -0.002}, {0.0001, 0.0035, -0.002}}});
  scenes.push_back(
      {"sphere",
       SceneBuilder().sphere(0.05, rough(mode), {{0.0, 0.0, -0.05}, Eigen::Quaterniond::Identity()}).image(),
       press});
  scenes.push_back(
      {"groove of two planes",
       SceneBuilder().plane(left_n, 0.0, rough(mode, 600.0)).plane(right_n, 0.0, rough(mode, 1400.0)).image(),
       groove});
  scenes.push_back({"groove of one mesh",
                    SceneBuilder().mesh(v_groove(90.0, 0.03, 0.2, 11), rough(mode)).image(), groove});
  scenes.push_back({"shaded icosphere",
                    SceneBuilder()
                        .mesh(icosphere(3, 0.05), rough(mode), {host::MeshSide::kOutside, 40.0},
                              {{0.0, 0.0, -0.05}, Eigen::Quaterniond::Identity()})
                        .image(),
                    press});
  return scenes;
}

// A slip that rounding alone would make longer was taken for one over a ridge: friction dropped out for a tick, or for as long as the
// tip stood still.
TEST(Friction, NeverDropsOutByRounding) {
  Random random(9);
  constexpr int kScenes = kUnderSanitizers ? 20 : 200;
  constexpr int kSlideTicks = 1000;
  constexpr int kStopTicks = 6;  // less than what steady friction needs to stick
  double worst = 0.0;
  for (int scene = 0; scene < kScenes; ++scene) {
    Material material = rough(FrictionMode::Steady, random.uniform(100.0, 1000.0));
    material.dynamic_friction = static_cast<float>(random.uniform(0.02, 1.0));
    material.static_friction = material.dynamic_friction;
    if (random.below(2) == 0) material.static_friction *= 1.5F;
    const Vector3d normal = random.direction();
    const Vector3d on_surface_m = random.in_box(Vector3d::Constant(0.1));
    const SceneImage image = SceneBuilder().plane(normal, normal.dot(on_surface_m), material).image();
    const Vector3d along = normal.cross(random.direction()).normalized();
    const double depth_m = random.uniform(0.0003, 0.002);
    const double step_m = random.uniform(0.2e-6, 5.0e-6);
    const double breaks_away_m = 1.05 * static_cast<double>(material.static_friction) * depth_m;
    IdealRun run(image);
    run.restart(on_surface_m + 0.001 * normal);
    run.move(on_surface_m - depth_m * normal, 2.5e-5);
    const auto slid = [&](double way_m) { return Vector3d(on_surface_m - depth_m * normal + way_m * along); };
    run.move(slid(breaks_away_m), 2.5e-5);
    for (int tick = 0; tick < kSlideTicks; ++tick) {
      const int moves = tick / 40 * (40 - kStopTicks) + std::min(tick % 40, 40 - kStopTicks);
      run.step(slid(breaks_away_m + moves * step_m));
      const double normal_N = run.felt().force_N.dot(normal);
      const double friction_N = -run.felt().force_N.dot(along);
      worst = std::max(
          worst, std::abs(friction_N / (static_cast<double>(material.dynamic_friction) * normal_N) - 1.0));
    }
  }
  figure("sliding and stopping on random planes: |F_t / (mu_d F_n) - 1|", worst, "0.01");
  EXPECT_LE(worst, 0.01);
}

TEST(Friction, AStillTipDoesNotDrift) {
  for (const FrictionMode mode : {FrictionMode::StickSlip, FrictionMode::Steady}) {
    for (const Still& still : still_scenes(mode)) {
      for (const bool noisy : {false, true}) {
        Random random(8);
        IdealRun run(still.image);
        run.step(still.path.front());
        for (const Vector3d& point : still.path) run.move(point, 2.5e-6);
        const Vector3d rest = still.path.back();
        // A tip that slid up to here and stops needs a moment to count as still.
        constexpr int kStopTicks = 40;
        for (int tick = 0; tick < kStopTicks; ++tick)
          run.step(noisy ? Vector3d(rest + 2e-6 * random.in_box(Vector3d::Ones())) : rest);
        const Felt start = run.step(rest);
        ASSERT_GT(start.force_N.norm(), 0.5) << still.name;
        double drift = 0.0;
        for (int tick = 0; tick < kStillTicks; ++tick) {
          run.step(noisy ? Vector3d(rest + 2e-6 * random.in_box(Vector3d::Ones())) : rest);
          if (noisy && tick % 64 != 63) continue;
          if (noisy) run.step(rest);
          drift = std::max(drift, (run.felt().god_object_m - start.god_object_m).norm());
        }
        figure(std::string("drift, ") + scene::EnumNameFrictionMode(mode) + ", " + still.name +
                   (noisy ? ", +-2 um of noise" : ", still") + ", of " + std::to_string(kStillTicks) +
                   " ticks, um",
               1e6 * drift, "1");
        EXPECT_LT(drift, 1e-6) << still.name;
      }
    }
  }
}

}  // namespace
}  // namespace thimble::test
