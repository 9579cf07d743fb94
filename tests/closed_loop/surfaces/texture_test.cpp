// Textures (paper, section 3.8): a tile that repeats without a seam, laid out in metres, whose height is a potential.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

constexpr double kStiffness_N_m = 1000.0;
constexpr double kTile_m = 0.004;
constexpr double kHeight_m = 0.0002;
constexpr double kWave_per_m = 2.0 * std::numbers::pi / kTile_m;

std::string textured(const std::string& kind, const std::string& rest = {},
                     const std::string& source = "\"pattern\": \"cos_cos\"") {
  return "\"stiffness_N_m\": 1000" + rest + R"(, "texture": {"kind": ")" + kind +
         R"(", "tile_m": [0.004, 0.004], "height_m": 0.0002, )" + source + "}";
}

// z = cos x cos y with its top on the surface.
double height_m(const Vector3d& p) {
  return 0.5 * kHeight_m * (std::cos(kWave_per_m * p.x()) * std::cos(kWave_per_m * p.y()) - 1.0);
}
Vector3d slope(const Vector3d& p) {
  const double a = -0.5 * kHeight_m * kWave_per_m;
  return {a * std::sin(kWave_per_m * p.x()) * std::cos(kWave_per_m * p.y()),
          a * std::cos(kWave_per_m * p.x()) * std::sin(kWave_per_m * p.y()), 0};
}

TEST(Texture, ForcesAreThoseOfTheFormulas) {
  const SceneImage height = surface_scene(textured("height"));
  const SceneImage normal = surface_scene(textured("normal"));
  const SceneImage lateral = surface_scene(textured("lateral"));
  Random random(3);
  double worst_height_N = 0;
  double worst_normal_N = 0;
  double worst_lateral_N = 0;
  double touched_above_relief = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = random.in_box({0.02, 0.02, 0}) - Vector3d(0, 0, random.uniform(0, 0.001));
    const auto press = [&](const SceneImage& image) {
      IdealRun run(image);
      run.restart(p + Vector3d(0, 0, 0.002));
      return run.step(p);
    };
    const Vector3d up = Vector3d::UnitZ();
    const double depth_m = -p.z();
    const double pressed_m = std::max(depth_m + height_m(p), 0.0);
    const Felt on_height = press(height);
    worst_height_N =
        std::max(worst_height_N, (on_height.force_N - kStiffness_N_m * pressed_m * (up - slope(p))).norm());
    if (pressed_m == 0) touched_above_relief = std::max(touched_above_relief, on_height.force_N.norm());
    worst_normal_N =
        std::max(worst_normal_N,
                 (press(normal).force_N - kStiffness_N_m * depth_m * (up - slope(p)).normalized()).norm());
    worst_lateral_N = std::max(worst_lateral_N,
                               (press(lateral).force_N - kStiffness_N_m * depth_m * (up - slope(p))).norm());
  }
  figure("height: largest difference from K (d + h)(n - grad h), N", worst_height_N, "0.001, of up to 1");
  figure("height: largest force over the relief, N", touched_above_relief, "0.001");
  figure("normal: largest difference from K d n', N", worst_normal_N, "0.001");
  figure("lateral: largest difference from K d (n - grad h), N", worst_lateral_N, "0.001");
  EXPECT_LT(worst_height_N, 1e-3);
  EXPECT_LT(touched_above_relief, 1e-3);
  EXPECT_LT(worst_normal_N, 1e-3);
  EXPECT_LT(worst_lateral_N, 1e-3);
}

// Seams lie at multiples of the tile. A height of random numbers would show a step that a cosine cannot.
TEST(Texture, TilesWithoutAStepAtTheSeam) {
  for (const char* pattern : {"cos_cos", "noise"}) {
    for (const char* kind : {"height", "normal", "lateral"}) {
      const SceneImage image =
          surface_scene(textured(kind, "", std::string("\"pattern\": \"") + pattern + "\""));
      IdealRun run(image);
      constexpr double kStep_m = 1e-6;
      double at_seam_N = 0;
      double elsewhere_N = 0;
      for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(1, 1, 0)}) {
        const Vector3d start(-0.0063, -0.0061, -0.0005);
        run.restart({start.x(), start.y(), 0.001});
        run.step(start);
        for (int i = 1; i < 12000; ++i) {
          const Vector3d before_N = run.felt().force_N;
          const Vector3d from = run.felt().tip_m;
          run.step(start + kStep_m * i * way);
          const double step_N = (run.felt().force_N - before_N).norm() / (run.felt().tip_m - from).norm();
          const auto tile = [&](double x) { return std::floor(x / kTile_m); };
          const bool seam =
              tile(from.x()) != tile(run.felt().tip_m.x()) || tile(from.y()) != tile(run.felt().tip_m.y());
          (seam ? at_seam_N : elsewhere_N) = std::max(seam ? at_seam_N : elsewhere_N, step_N);
        }
      }
      const std::string what = std::string(kind) + " " + pattern;
      figure(what + ": force's step over travel at a seam, over K", at_seam_N / kStiffness_N_m,
             "no more than elsewhere: " + std::to_string(elsewhere_N / kStiffness_N_m));
      EXPECT_LE(at_seam_N, 1.02 * elsewhere_N);
      if (std::string(pattern) == "cos_cos") {
        EXPECT_LT(at_seam_N, kStiffness_N_m);
      }
    }
  }
}

// Two faces, one with edges of 30 mm and one of 10 mm, each tilted another way.
TEST(Texture, HasTheSameSpatialFrequencyOnFacetsOfAnySize) {
  const TemporaryFolder folder;
  folder.write("facets.obj",
               "v 0 0 0\nv 0.03 0 0.01\nv 0.03 0.03 0.01\nv 0 0.03 0\n"          // rises to +x
               "v 0.05 0 0\nv 0.06 0 0\nv 0.06 0.01 0.004\nv 0.05 0.01 0.004\n"  // rises to +y
               "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n");
  const SceneImage image = surface_scene(textured("height", "", "\"pattern\": \"cos_cos\""),
                                         R"("mesh": {"file": "facets.obj"})", folder.path());
  struct Facet {
    Vector3d corner;
    Vector3d u;  // along one side, and square to it on the face
    Vector3d normal;
    double side_m;
  };
  const double rise = std::sqrt(0.03 * 0.03 + 0.01 * 0.01);
  const std::vector<Facet> facets{
      {{0, 0, 0}, Vector3d(0.03, 0, 0.01) / rise, Vector3d(-0.01, 0, 0.03) / rise, 0.03},
      {{0.05, 0, 0}, {1, 0, 0}, Vector3d(0, -0.004, 0.01).normalized(), 0.01}};
  for (const Facet& facet : facets) {
    const Vector3d v = facet.normal.cross(facet.u);
    for (const bool along_u : {true, false}) {
      IdealRun run(image);
      const Vector3d& way = along_u ? facet.u : v;
      const Vector3d& across = along_u ? v : facet.u;
      const double length_m = 0.8 * facet.side_m;
      std::vector<double> force_N;
      constexpr double kStep_m = 1e-5;
      // Along the line across which the ridges run highest: a multiple of the tile.
      const double beside = kTile_m * std::ceil((facet.corner.dot(across) + 0.002) / kTile_m);
      const Vector3d start =
          facet.corner + across * (beside - facet.corner.dot(across)) + 0.1 * facet.side_m * way;
      run.restart(start + 0.001 * facet.normal);
      run.move(start - 0.0005 * facet.normal, 1e-4);
      for (double s = 0; s < length_m; s += kStep_m) {
        force_N.push_back(run.step(start + s * way - 0.0005 * facet.normal).force_N.dot(facet.normal));
      }
      const double waves_per_m = peak_frequency(force_N, 1.0 / kStep_m, 150, 400, 500);
      figure("waves per metre on a facet of " + std::to_string(1e3 * facet.side_m) + " mm" +
                 (along_u ? ", u" : ", v"),
             waves_per_m, "250 within 2 %");
      EXPECT_NEAR(waves_per_m, 250.0, 5.0);
    }
  }
}

// A press, a wander under the surface and a release where it began. Returns the work on the hand over the most that it stored.
struct Loops {
  double most = -1e9;
  double least = 1e9;
};

Loops random_loops(const SceneImage& image, int loops, double step_m, bool reuse) {
  Random random(11);
  IdealRun run(image);
  Loops result;
  for (int loop = 0; loop < loops; ++loop) {
    const Vector3d start = random.in_box({0.01, 0.01, 0}) + Vector3d(0, 0, 0.0005);
    if (loop == 0 || !reuse) run.restart(start);
    run.move(start, step_m);
    const double before_J = run.work_mean_force_J();
    run.move(start - Vector3d(0, 0, random.uniform(0.0007, 0.0015)), step_m);
    for (int leg = 0; leg < 5; ++leg) {
      run.move(start + random.in_box({0.005, 0.005, 0}) - Vector3d(0, 0, random.uniform(0.0006, 0.0015)),
               step_m);
    }
    run.move(start - Vector3d(0, 0, 0.0008), step_m);
    run.move(start, step_m);
    const double stored_J = 0.5 * kStiffness_N_m * 1e-3 * 1e-3;
    const double given = (run.work_mean_force_J() - before_J) / stored_J;
    result.most = std::max(result.most, given);
    result.least = std::min(result.least, given);
  }
  return result;
}

TEST(Texture, AHeightsClosedPathsDoNoWork) {
  for (const char* pattern : {"cos_cos", "noise"}) {
    const Loops work =
        random_loops(surface_scene(textured("height", "", std::string("\"pattern\": \"") + pattern + "\"")),
                     40, 5e-6, false);
    figure(std::string(pattern) + ": closed-path work over that of a press of 1 mm, most", work.most,
           "0 within 0.001");
    figure(std::string(pattern) + ": least", work.least, "0 within 0.001");
    EXPECT_LT(work.most, 1e-3);
    EXPECT_GT(work.least, -1e-3);
  }
}

TEST(Texture, AHeightRoundACylinderDoesNoWorkEither) {
  const SceneImage image =
      surface_scene(textured("height", "", "\"pattern\": \"cos_cos\""),
                    R"("cylinder": {"radius_m": 0.015278874536821952, "height_m": 0.06})");
  IdealRun run(image);
  Random random(5);
  double most = 0;
  double at_seam_N = 0;
  for (int loop = 0; loop < 30; ++loop) {
    const auto at = [](double angle, double z, double depth) {
      return Vector3d((0.01527887 - depth) * std::cos(angle), (0.01527887 - depth) * std::sin(angle), z);
    };
    const double angle = random.uniform(2.5, 3.7);  // the seam of the unrolled side is at pi
    run.restart(at(angle, 0, -0.001));
    run.move(at(angle, 0, 0.001), 5e-6);
    double last = angle;
    for (int leg = 0; leg < 5; ++leg) {
      const double next = leg == 4 ? angle : random.uniform(2.5, 3.7);
      const double z = leg == 4 ? 0.0 : random.uniform(-0.01, 0.01);
      const Vector3d from = run.felt().tip_m;
      const double depth = leg == 4 ? 0.001 : random.uniform(0.0005, 0.002);
      constexpr int kSteps = 2000;
      for (int i = 1; i <= kSteps; ++i) {
        const double part = static_cast<double>(i) / kSteps;
        const double radius = 0.01527887 - from.head<2>().norm();
        const Vector3d before_N = run.felt().force_N;
        const Vector3d was = run.felt().tip_m;
        run.step(at(last + part * (next - last), from.z() + part * (z - from.z()),
                    radius + part * (depth - radius)));
        if (was.y() * run.felt().tip_m.y() < 0)
          at_seam_N =
              std::max(at_seam_N, (run.felt().force_N - before_N).norm() / (run.felt().tip_m - was).norm());
      }
      last = next;
    }
    run.move(at(angle, 0, -0.001), 5e-6);
    most = std::max(most, std::abs(run.work_on_hand_J() == 0 ? 1.0 : run.work_mean_force_J()) / (0.5e-3));
  }
  figure("cylinder: closed-path work over that of a press of 1 mm", most, "0.002");
  figure("cylinder: force's step over travel across the unrolled side's seam, over K",
         at_seam_N / kStiffness_N_m, "1");
  EXPECT_LT(most, 2e-3);
  EXPECT_LT(at_seam_N, kStiffness_N_m);
}

// Minsky's force and turned normals have no potential: the account takes what a loop would give.
TEST(Texture, LateralAndNormalGiveTheHandNothing) {
  for (const std::string kind : {"lateral", "normal"}) {
    for (const double friction : {0.0, 0.3}) {
      // Noise of 0.2 mm with samples 0.4 mm apart: slopes up to about 1.
      const SceneImage image =
          surface_scene("\"stiffness_N_m\": 1000, \"static_friction\": " + std::to_string(friction) +
                        R"(, "texture": {"kind": ")" + kind +
                        R"(", "tile_m": [0.0128, 0.0128], "height_m": 0.0002, "pattern": "noise"})");
      const Loops work = random_loops(image, 100, 1e-5, false);
      const std::string what = std::string(kind) + " with friction " + std::to_string(friction);
      figure(what + ": most that a loop gave over a press of 1 mm", work.most, "0.005");
      figure(what + ": least", work.least, "reported: what the loops cost");
      EXPECT_LT(work.most, 5e-3);
    }
  }
}

TEST(Texture, HeightAndFrictionWorkTogether) {
  const SceneImage image = surface_scene(
      textured("height", R"(, "static_friction": 0.5, "dynamic_friction": 0.5, "friction_mode": "steady")"));
  IdealRun run(image);
  run.restart({-0.01, 0, 0.001});
  run.move({-0.01, 0, -0.0006}, 2e-5);
  run.move({0.0, 0, -0.0006}, 2e-5);
  // While it slides along x: F = K p (n - grad h), and mu |that| against the way, along the shape's surface.
  double worst_N = 0;
  double most_drag_N = 0;
  double least_drag_N = 1e9;
  for (int i = 1; i < 400; ++i) {
    const Vector3d p(2e-5 * i, 0, -0.0006);
    const Felt& felt = run.step(p);
    const Vector3d normal_N = kStiffness_N_m * (0.0006 + height_m(p)) * (Vector3d::UnitZ() - slope(p));
    const double drag_N = normal_N.x() - felt.force_N.x();
    worst_N = std::max(worst_N, std::abs(drag_N - 0.5 * normal_N.norm()));
    most_drag_N = std::max(most_drag_N, drag_N);
    least_drag_N = std::min(least_drag_N, drag_N);
  }
  figure("friction less mu times the textured normal force, N", worst_N, "0.02, of 0.2 to 0.3");
  figure("friction at most over at least", most_drag_N / least_drag_N, "> 1.4: it follows the relief");
  EXPECT_LT(worst_N, 0.02);
  EXPECT_GT(most_drag_N / least_drag_N, 1.4);
  const Loops work = random_loops(image, 60, 2e-5, false);
  figure("height with friction: most that a loop gave over a press of 1 mm", work.most, "0");
  EXPECT_LT(work.most, 0.0);
}

TEST(Texture, HeightsFromNumbersAreMetWhereTheyAre) {
  // Four columns, three rows, written as seen from above: the last row is v = 0.
  const SceneImage image =
      surface_scene(textured("height", "", "\"heights\": [[4, 1, 2, 0], [1, 3, 0, 2], [0, 1, 5, 1]]"));
  const std::vector<std::vector<double>> rows{{0, 1, 5, 1}, {1, 3, 0, 2}, {4, 1, 2, 0}};
  std::vector<double> scale;
  const auto depth_of_relief = [&](double u, double v) {
    const Vector3d p(u, v, -0.001);
    IdealRun run(image);
    run.restart({u, v, 0.001});
    return 0.001 - run.step(p).force_N.z() / kStiffness_N_m;
  };
  const double top = depth_of_relief(2 * 0.001, 0);
  const double foot = depth_of_relief(0, 0);
  double worst = 0;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 4; ++i) {
      const double share = (foot - depth_of_relief(0.001 * i + kTile_m, kTile_m / 3 * j)) / (foot - top);
      const double wanted = rows[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] / 5.0;
      worst = std::max(worst, std::abs(share - wanted));
    }
  }
  figure("heights from numbers: largest difference, over the whole height", worst, "0.001");
  EXPECT_LT(worst, 1e-3);
}

}  // namespace
}  // namespace thimble::test
