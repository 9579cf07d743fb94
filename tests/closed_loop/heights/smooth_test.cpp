// SMOOTH and ASTEROID: force shading on coarse meshes, and the asteroid from outside and from inside, along
// the strokes of the scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "board/sim/hand_path.h"
#include "board/sim/hand_path_file.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/mesh_file.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/scene.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = fs::path(THIMBLE_SOURCE_DIR) / "scenes";

SceneImage load(const std::string& name) {
  return SceneImage(host::compile_scene(kScenes / name / (name + ".scene.json")).image);
}

board::HandPath hand(const std::string& name) {
  return board::HandPath(board::read_hand_path(kScenes / name / "stroke.csv"));
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

// Great circles over a ball of 80 triangles, the tip 0.1 mm further each tick.
TEST(Smooth, EightyTrianglesPushLikeASphere) {
  constexpr double kRadius_m = 0.03;
  const host::CompiledMesh ball = host::compile_mesh(
      icosphere(1, kRadius_m), {.side = host::MeshSide::kOutside, .crease_deg = 180.0}, "ball");
  const MeshOracle oracle(as_soup(ball));
  const SceneImage image = SceneBuilder().mesh(ball, {}).image();
  IdealRun run(image);
  Random random(8);
  // The faces' middles lie 1.9 mm below the sphere. The sphere's force takes no work on a circle, so it may not store more than
  // the press began with. Where that was over a middle, and the circle lies less than 4 mm deep, it would be next to none over
  // the vertices, several times as deep: there the faces are felt instead, up to 18 degrees off.
  for (const double depth_m : {0.002, 0.003, 0.004, 0.005, 0.008}) {
    const bool shallow = depth_m < 0.004;
    double off_deg = 0;
    double jump_deg = 0;
    double least = 1;
    for (int circle = 0; circle < 40; ++circle) {
      const Vector3d a = random.direction();
      const Vector3d b = a.cross(random.direction()).normalized();
      const double r = kRadius_m - depth_m;
      const double step = 1e-4 / r;
      run.restart(1.1 * kRadius_m * a);
      Vector3d before = run.step(r * a).force_N;
      for (int i = 1; i * step < 2.0 * std::numbers::pi; ++i) {
        const Vector3d out = std::cos(i * step) * a + std::sin(i * step) * b;
        const Vector3d force = run.step(r * out).force_N;
        off_deg = std::max(off_deg, angle_deg(force, out));
        jump_deg = std::max(jump_deg, angle_deg(force, before));
        least = std::min(least, -force.norm() / (kDefaultStiffness_N_m * oracle.signed_distance(r * out)));
        before = force;
      }
    }
    const std::string name = "80 triangles, " + std::to_string(std::lround(1e3 * depth_m)) + " mm deep: ";
    figure(name + "force off the sphere's, degrees", off_deg, shallow ? "25" : "3");
    figure(name + "turn of the force over 0.1 mm, degrees", jump_deg, shallow ? "20" : "1");
    figure(name + "least force, K times the depth behind the faces", least, "0.1");
    EXPECT_LT(off_deg, shallow ? 25.0 : 3.0);
    EXPECT_LT(jump_deg, shallow ? 20.0 : 1.0);
    EXPECT_GT(least, 0.1);
  }
}

struct Stroke {
  double jump_deg = 0;    // largest turn of the force over a piece of its way
  double touching_s = 0;  // time in contact
  double least_N = 1e9;   // of the push along `god object - tip`
};

// Plays a hand from `begin_s` to `end_s`, all of it in contact, and measures turns every `over_m` of its way.
Stroke play(const SceneImage& image, const board::HandPath& path, double begin_s, double end_s,
            double over_m = 1e-4) {
  IdealRun run(image);
  Stroke stroke;
  Vector3d before = Vector3d::Zero();
  double way_m = 0;
  Vector3d last = path.at(path.start_s()).position_m;
  run.restart(last);
  constexpr double kTick_s = 1.0 / kRate_Hz;
  for (double t = path.start_s(); t <= path.end_s(); t += kTick_s) {
    const Vector3d tip = path.at(t).position_m;
    const Felt& felt = run.step(tip);
    way_m += (tip - last).norm();
    last = tip;
    if (felt.contacts > 0) stroke.touching_s += kTick_s;
    if (t < begin_s || t > end_s) continue;
    stroke.least_N =
        std::min(stroke.least_N, felt.force_N.dot((felt.god_object_m - felt.tip_m).normalized()));
    if (way_m < over_m) continue;
    if (!before.isZero()) stroke.jump_deg = std::max(stroke.jump_deg, angle_deg(felt.force_N, before));
    before = felt.force_N;
    way_m = 0;
  }
  return stroke;
}

TEST(Smooth, TheAsteroidsEdgesAreGoneAndCreasesStay) {
  const auto asteroid = [](std::optional<double> crease_deg) {
    return SceneBuilder()
        .mesh(host::read_mesh_file(kScenes / "asteroid" / "asteroid.plg", 1e-5, "asteroid"), {},
              {.side = host::MeshSide::kOutside, .crease_deg = crease_deg}, {Vector3d(-0.045, 0, -0.055)})
        .image();
  };
  const board::HandPath path = hand("smooth");
  const auto turn = [&](const SceneImage& image, double over_m) {
    return play(image, path, 1.21, 5.19, over_m).jump_deg;
  };
  const double smooth = figure("smooth scene, asteroid: turn of the force over 0.1 mm, degrees",
                               turn(load("smooth"), 1e-4), "1");
  const double faceted = figure("the same, faceted", turn(asteroid({}), 1e-4), "above 15");
  EXPECT_LT(smooth, 1.0);
  EXPECT_GT(faceted, 15.0);
  // A crease of a shaded mesh turns the force no faster than the tip moves (control/contact/shading.h).
  const double round =
      figure("smooth scene, asteroid: turn over 1 mm, degrees", turn(load("smooth"), 1e-3), "reported");
  const double creased =
      figure("the same, edges above 25 degrees sharp", turn(asteroid(25.0), 1e-3), "above 10");
  EXPECT_GT(creased, 10.0);
  EXPECT_GT(creased, 1.5 * round);
}

// Round on the tube of scenes/ring, 32 faces about, with the scene's crease_deg.
TEST(Smooth, TheRingIsRound) {
  const SceneImage image = SceneBuilder()
                               .mesh(host::read_mesh_file(kScenes / "ring" / "ring.obj", 0.001, "ring"), {},
                                     {.side = host::MeshSide::kOutside, .crease_deg = 40.0})
                               .image();
  IdealRun run(image);
  double off_deg = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double around = 2.0 * std::numbers::pi * i / 4000.0;
    const double across = std::numbers::pi * (0.5 + 0.35 * std::sin(7.0 * around));  // on its upper half
    const Vector3d outwards(std::cos(around), std::sin(around), 0.0);
    const Vector3d out = std::cos(across) * outwards + std::sin(across) * Vector3d::UnitZ();
    const Vector3d middle = 0.024 * outwards + 0.006 * Vector3d::UnitZ();
    if (i == 0) run.restart(middle + 0.008 * out);
    off_deg = std::max(off_deg, angle_deg(run.step(middle + 0.0045 * out).force_N, out));
  }
  figure("ring: force off the tube's, degrees", off_deg, "2");
  EXPECT_LT(off_deg, 2.0);
}

// Follows the scene's hand; `inside` is where the free space is.
void probe(const std::string& name, const Vector3d& middle, double scale, bool inside) {
  host::TriangleSoup soup = as_soup(host::compile_mesh(
      host::read_mesh_file(kScenes / "asteroid" / "asteroid.plg", scale, "asteroid"),
      {.side = inside ? host::MeshSide::kInside : host::MeshSide::kOutside, .crease_deg = {}}, name));
  for (Vector3d& v : soup.vertices_m) v += middle;
  const MeshOracle oracle(soup);
  const SceneImage image = load(name);
  const board::HandPath path = hand(name);
  IdealRun run(image);
  run.restart(path.at(path.start_s()).position_m);
  double deepest_m = 0;       // of the tip, behind the surface
  double lowest_m = 1.0;      // of the god object, in front of it
  double least_N = 1e9;       // push to the free side, where the tip is 1 mm deep or more
  double least_cosine = 1.0;  // between the force and the way out at the god object
  int deep = 0;
  int missed = 0;
  int tick = 0;
  for (double t = path.start_s(); t <= path.end_s(); t += 1.0 / kRate_Hz) {
    const Felt& felt = run.step(path.at(t).position_m);
    if (tick++ % 8 != 0) continue;
    const double tip_m = oracle.signed_distance(felt.tip_m);
    deepest_m = std::max(deepest_m, -tip_m);
    lowest_m = std::min(lowest_m, oracle.signed_distance(felt.god_object_m));
    if (tip_m > -0.001) continue;
    ++deep;
    if (felt.contacts == 0) ++missed;
    const Vector3d out = (inside ? -1.0 : 1.0) * (felt.god_object_m - middle).normalized();
    least_N = std::min(least_N, felt.force_N.norm());
    least_cosine = std::min(least_cosine, felt.force_N.normalized().dot(out));
  }
  figure(name + ": deepest tip, mm", 1e3 * deepest_m, "above 2.5");
  figure(name + ": god object in front of the surface, at least, um", 1e6 * lowest_m, "-0.5");
  figure(name + ": least force 1 mm deep, N", least_N, "0.9");
  figure(name + ": least cosine between force and the way out", least_cosine, "0.3");
  figure(name + ": ticks without contact 1 mm deep", missed, "0");
  EXPECT_GT(deepest_m, 0.0025);
  EXPECT_GT(lowest_m, -5e-7);
  EXPECT_GT(least_N, 0.9);
  EXPECT_GT(least_cosine, 0.3);
  EXPECT_EQ(missed, 0);
  EXPECT_GT(deep, 1000);
}

TEST(Asteroid, PushesOutwardsAllAlongItsStroke) { probe("asteroid", {0, 0, -0.055}, 1e-5, false); }
TEST(Asteroid, PushesInwardsFromInsideAllAlongItsStroke) {
  probe("asteroid-inside", {0, 0, 0}, 1.5e-5, true);
}

}  // namespace
}  // namespace thimble::test
