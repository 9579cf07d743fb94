// A tip with a radius over random scenes, with jumps of up to 5 mm per tick. The judge knows distances in double
// precision only: the sphere never comes nearer to a solid than its radius, and where it rests, no place that it could go
// to straight is nearer to the tip. THIMBLE_TIP_RADIUS_TICKS sets the number of ticks of the meshes, THIMBLE_TIP_RADIUS_SEED
// the seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/heap.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/peer_path.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kNearer_m = 2e-6;  // by this the sphere may be in a surface: rounding

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}

std::uint64_t seed() { return static_cast<std::uint64_t>(from_environment("THIMBLE_TIP_RADIUS_SEED", 1.0)); }

TEST(TipRadius, NothingHoldsTheSphereButSolids) {
  const int scenes = kUnderSanitizers ? 2 : 30;
  long rests = 0;
  long held = 0;
  long silent = 0;
  double worst_m = 0.0;
  double deepest_m = -1.0;
  for (int index = 0; index < scenes; ++index) {
    Random random(900 + static_cast<std::uint64_t>(index));
    SceneBuilder builder;
    const std::vector<Solid> solids = random_heap(random, builder);
    const double radius_m = std::pow(10.0, random.uniform(-4.0, -2.2));
    const SceneImage image = builder.tip_radius(radius_m).image();
    IdealRun run(image);
    const auto free = [&](const Vector3d& from, const Vector3d& way) {
      constexpr int kPieces = 8;
      for (int i = 1; i <= kPieces; ++i)
        if (distance_m(solids, from + way * (1.0 * i / kPieces)) < radius_m + 1e-6) return false;
      return true;
    };
    for (int poke = 0; poke < 25; ++poke) {
      run.restart(0.05 * random.direction());
      if (distance_m(solids, run.felt().tip_m) < radius_m + 1e-3) continue;
      Vector3d tip = random.in_box(Vector3d::Constant(0.012));
      run.move(tip, 1e-4);
      for (int slide = 0; slide < 4; ++slide) {
        tip += random.in_box(Vector3d::Constant(0.004));
        run.move(tip, 1e-4);
        for (int settle = 0; settle < 20; ++settle) run.step(tip);
        const Felt& felt = run.felt();
        deepest_m = std::max(deepest_m, radius_m - distance_m(solids, felt.god_object_m));
        if (felt.contacts == 0) {
          if ((felt.god_object_m - felt.tip_m).norm() > 1e-6) ++silent;
          continue;
        }
        ++rests;
        double nearer_m = 0.0;
        for (int n = 0; n < 120; ++n) {
          const Vector3d way = std::pow(10.0, random.uniform(-4.5, -3.3)) * random.direction();
          const double gain =
              (felt.god_object_m - felt.tip_m).norm() - (felt.god_object_m + way - felt.tip_m).norm();
          if (gain > 2e-6 && gain > nearer_m && free(felt.god_object_m, way)) nearer_m = gain;
        }
        if (nearer_m > 0.0) ++held;
        worst_m = std::max(worst_m, nearer_m);
      }
    }
  }
  figure("tip radius, random heaps: places of rest in contact", static_cast<double>(rests), "");
  figure("tip radius, random heaps: sphere deepest in a solid, um", 1e6 * deepest_m, "2");
  figure("tip radius, random heaps: of them held by nothing", static_cast<double>(held), "0");
  figure("tip radius, random heaps: held without contact", static_cast<double>(silent), "0");
  figure("tip radius, random heaps: nearest place that was free, um nearer", 1e6 * worst_m, "0");
  EXPECT_GT(rests, kUnderSanitizers ? 30 : 1000);
  EXPECT_LT(deepest_m, kNearer_m);
  EXPECT_EQ(held, 0);
  EXPECT_EQ(silent, 0);
}

struct MeshCase {
  std::string name;
  host::TriangleSoup soup;
  double radius_m;
  host::MeshSide side = host::MeshSide::kOutside;
  bool rims = true;  // as the compiler gives them; false: as an older one did
  bool friction = false;
};

// A post with lobes: its walls are of two triangles each, 40 mm long and less than 1 mm wide.
host::TriangleSoup lobed_post(std::uint32_t sides, double depth) {
  host::TriangleSoup soup;
  for (const double z : {-0.02, 0.02}) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double turn = 2.0 * std::numbers::pi * i / sides;
      const double radius_m = 0.02 * (1.0 + depth * std::cos(5.0 * turn));
      soup.vertices_m.emplace_back(radius_m * std::cos(turn), radius_m * std::sin(turn), z);
    }
  }
  for (const double z : {-0.02, 0.02}) soup.vertices_m.emplace_back(0.0, 0.0, z);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    soup.triangles.push_back({i, next, sides + next});
    soup.triangles.push_back({i, sides + next, sides + i});
    soup.triangles.push_back({2 * sides, next, i});
    soup.triangles.push_back({2 * sides + 1, sides + i, sides + next});
  }
  return soup;
}

// From place to place near the surface, in steps of any length up to 5 mm.
Vector3d next_target(const MeshOracle& oracle, const Vector3d& from, double radius_m, Random& random) {
  std::uint32_t best = 0;
  double best_m = 1e9;
  for (int i = 0; i < 6; ++i) {
    const auto face = static_cast<std::uint32_t>(random.below(oracle.size()));
    const double distance = (oracle.corner(face, 0) - from).norm();
    if (distance < best_m) {
      best = face;
      best_m = distance;
    }
  }
  return oracle.corner(best, 0) +
         (random.uniform(-0.004, 0.002) + random.uniform(0.0, radius_m)) * oracle.normal(best);
}

std::vector<MeshCase> mesh_cases() {
  const auto outside = host::MeshSide::kOutside;
  std::vector<MeshCase> cases = {
      {"icosphere 1280, 1 mm", icosphere(3, 0.03), 0.001},
      {"icosphere 20480, 4 mm", icosphere(5, 0.03), 0.004},
      {"plate of 0.1 mm, 2 mm", box_mesh({0.03, 0.03, 1e-4}, 5), 0.002},
      {"knife of 8 degrees, 1 mm", knife(8.0, 0.03, 0.05, 9), 0.001},
      {"groove of 40 degrees, 3 mm", v_groove(40.0, 0.01, 0.05, 7), 0.003},
      {"torus, 5 mm", torus(0.02, 0.006, 40, 20), 0.005},
      {"hostile terrain, 0.3 mm", hostile_terrain(40, 0.001, 0.002, 7), 0.0003},
      {"hostile terrain, 1 mm", hostile_terrain(40, 0.001, 0.002, 7), 0.001},
      {"hostile terrain, 5 mm", hostile_terrain(40, 0.001, 0.002, 7), 0.005},
      {"cube room, 3 mm", box_mesh({0.04, 0.04, 0.04}, 6), 0.003, host::MeshSide::kInside},
      {"icosphere 1280 from inside, 10 mm", icosphere(3, 0.03), 0.01, host::MeshSide::kInside},
      {"post of 200 needles, 0.1 mm", lobed_post(200, 0.1), 0.0001},
      {"post of 120 needles, 0.3 mm", lobed_post(120, 0.2), 0.0003},
      {"post of 400 needles, 0.1 mm", lobed_post(400, 0.2), 0.0001},
      {"box of 12 triangles, 0.1 mm", box_mesh({0.03, 0.02, 0.015}, 1), 0.0001},
      {"BLEND/HUMAN.blend, 2 mm", test_model("BLEND/HUMAN.blend", 0.2), 0.002, outside}};
  const std::size_t count = cases.size();
  for (std::size_t i = 0; i < count; ++i) {
    cases[i].friction = i % 2 == 0;
    cases.push_back(cases[i]);
    cases.back().name += ", without rims";
    cases.back().rims = false;
    cases.back().friction = !cases[i].friction;
  }
  return cases;
}

host::CompiledMesh compile(const MeshCase& test) {
  return host::compile_mesh(
      test.soup, {.side = test.side, .crease_deg = {}, .tip_radius_m = test.rims ? test.radius_m : 0.0},
      test.name);
}

// The faces at a sharp vertex can all look away from a place outside, so the nearest one does not tell.
bool is_inside(const MeshOracle& oracle, const Vector3d& p, host::MeshSide side) {
  const bool enclosed = oracle.crossings(p, p + Vector3d(0.83, 0.41, 0.37)).size() % 2 == 1;
  return enclosed == (side == host::MeshSide::kOutside);
}

// Whether a place nearer to the tip is free all the way to it.
bool is_held_by_nothing(const MeshOracle& oracle, const Vector3d& god, const Vector3d& tip, double radius_m,
                        Random& random) {
  constexpr int kWays = 40;
  constexpr int kPieces = 200;
  for (int n = 0; n < kWays; ++n) {
    const Vector3d way = std::pow(10.0, random.uniform(-4.5, -3.3)) * random.direction();
    if ((god - tip).norm() - (god + way - tip).norm() <= 2e-6) continue;
    bool free = true;
    for (int i = 1; i <= kPieces && free; ++i)
      free = oracle.nearest(god + way * (1.0 * i / kPieces)).distance_m >= radius_m + 1e-6;
    if (free) return true;
  }
  return false;
}

TEST(TipRadius, NeverComesNearerToAMeshThanItsRadius) {
  const auto outside = host::MeshSide::kOutside;
  const std::vector<MeshCase> cases = mesh_cases();
  const double total = from_environment("THIMBLE_TIP_RADIUS_TICKS", kUnderSanitizers ? 1.2e4 : 2.4e5);
  const auto ticks = static_cast<long>(total / static_cast<double>(cases.size()));
  for (const MeshCase& test : cases) {
    const host::CompiledMesh mesh = compile(test);
    const MeshOracle oracle(as_soup(mesh));
    Random random(seed() * 100 + 7);
    const Pose pose{random.in_box(Vector3d::Constant(0.02)), random_turn(random)};
    const Material material{.damping_N_s_m = 1.0F,
                            .static_friction = test.friction ? 0.4F : 0.0F,
                            .dynamic_friction = test.friction ? 0.3F : 0.0F};
    const SceneImage image = SceneBuilder().mesh(mesh, material, pose).tip_radius(test.radius_m).image();
    IdealRun run(image);
    const auto to_local = [&](const Vector3d& p) {
      return Vector3d(pose.rotation.conjugate() * (p - pose.position_m));
    };
    Vector3d tip = Vector3d::Zero();
    Vector3d target = tip;
    double step_m = 0.0;
    long falls = 0;
    long silent = 0;
    long held = 0;
    long in_contact = 0;
    double nearest_m = 1.0;
    for (long tick = 0; tick < ticks; ++tick) {
      if (tick % 1000 == 0) {
        do {
          tip = oracle.bounds().center() +
                random.in_box((test.side == outside ? 0.8 : 0.3) * oracle.bounds().sizes());
        } while (oracle.signed_distance(tip) < test.radius_m + 1e-4);
        run.restart(pose.position_m + pose.rotation * tip);
        target = tip;
      }
      if ((target - tip).norm() < 1e-9 || random.below(60) == 0) {
        target = next_target(oracle, tip, test.radius_m, random);
        constexpr double kSteps_m[] = {2.5e-5, 2e-4, 1e-3, 5e-3};
        step_m = kSteps_m[random.below(4)] * random.uniform(0.2, 1.0);
      }
      const Vector3d way = target - tip;
      tip = way.norm() <= step_m ? target : Vector3d(tip + way * (step_m / way.norm()));
      const Felt& felt = run.step(pose.position_m + pose.rotation * tip);
      const Vector3d god = to_local(felt.god_object_m);
      double distance = oracle.signed_distance(god, 0.02);
      if (distance < 0.0 && !is_inside(oracle, god, test.side)) distance = -distance;
      nearest_m = std::min(nearest_m, distance - test.radius_m);
      if (distance < test.radius_m - kNearer_m) ++falls;
      if (felt.contacts > 0) ++in_contact;
      if (felt.contacts == 0 && (felt.god_object_m - felt.tip_m).norm() > 1e-6) ++silent;
      if (test.friction || tick % 100 != 99) continue;
      for (int settle = 0; settle < 20; ++settle) run.step(pose.position_m + pose.rotation * tip);
      if (run.felt().contacts > 0 &&
          is_held_by_nothing(oracle, to_local(run.felt().god_object_m), tip, test.radius_m, random))
        ++held;
    }
    const std::string what = "tip radius, " + test.name + ": ";
    figure(what + "ticks in contact, %", 100.0 * static_cast<double>(in_contact) / static_cast<double>(ticks),
           "> 20");
    figure(what + "nearer than the radius", static_cast<double>(falls), "0");
    figure(what + "nearest, um from the radius", 1e6 * nearest_m, ">= -2");
    figure(what + "held without contact", static_cast<double>(silent), "0");
    figure(what + "at rest, held by nothing", static_cast<double>(held), "0");
    figure(what + "bounds hit, sweep and slide, % of the ticks",
           100.0 * (run.renderer().counters().sweep_bound + run.renderer().counters().slide_bound) /
               static_cast<double>(ticks),
           "");
    EXPECT_GT(5 * in_contact, ticks) << test.name;
    EXPECT_EQ(falls, 0) << test.name;
    EXPECT_EQ(silent, 0) << test.name;
    EXPECT_EQ(held, 0) << test.name;
  }
}

// The tip in the plane of a sheet, which it touches from either side: where the direction from the face to it is rounding alone.
TEST(TipRadius, ATipInThePlaneOfAFaceStaysOnItsSide) {
  long ticks = 0;
  double nearest_m = 1.0;
  for (const bool rims : {false, true}) {
    for (const double side : {-1.0, 1.0}) {
      for (const double radius_m : {1e-4, 3e-4, 1e-3, 3e-3}) {
        Random random(41);
        const Pose pose{random.in_box(Vector3d::Constant(0.02)), random_turn(random)};
        const SceneImage image =
            SceneBuilder()
                .mesh(sheet(0.08, 1), {}, {.crease_deg = {}, .tip_radius_m = rims ? radius_m : 0.0}, pose)
                .tip_radius(radius_m)
                .image();
        IdealRun run(image);
        Vector3d tip(0.0, 0.0, side * 0.02);
        run.restart(pose.position_m + pose.rotation * tip);
        for (int stroke = 0; stroke < 12; ++stroke) {
          constexpr double kHeights_m[] = {0.0, 1e-9, -1e-9, 1e-8, -1e-8};
          const Vector3d to(random.uniform(-0.035, 0.035), random.uniform(-0.035, 0.035),
                            kHeights_m[random.below(5)]);
          const int steps = kUnderSanitizers ? 50 : 500;
          for (int step = 1; step <= steps; ++step) {
            const Felt& felt =
                run.step(pose.position_m + pose.rotation * (tip + (to - tip) * (1.0 * step / steps)));
            const double height_m = (pose.rotation.conjugate() * (felt.god_object_m - pose.position_m)).z();
            nearest_m = std::min(nearest_m, side * height_m - radius_m);
            ++ticks;
          }
          tip = to;
        }
      }
    }
  }
  figure("tip radius, in the plane of a sheet: ticks", static_cast<double>(ticks), "");
  figure("tip radius, in the plane of a sheet: nearest, um from the radius", 1e6 * nearest_m, ">= -2");
  EXPECT_GE(nearest_m, -kNearer_m);
}

// The lists of triangles that are kept from tick to tick (control/solids/near_triangles.h) change no bit.
TEST(TipRadius, ListsOfTrianglesChangeNothing) {
  const int ticks = kUnderSanitizers ? 1000 : 6000;
  long differ = 0;
  long in_contact = 0;
  for (const MeshCase& test : mesh_cases()) {
    const host::CompiledMesh mesh = compile(test);
    const MeshOracle oracle(as_soup(mesh));
    Random random(seed() * 100 + 8);
    const Material material{.damping_N_s_m = 1.0F, .static_friction = 0.4F, .dynamic_friction = 0.3F};
    const Pose pose{random.in_box(Vector3d::Constant(0.02)), random_turn(random)};
    for (const double radius_m : {test.radius_m, 0.0}) {
      const SceneImage image = SceneBuilder().mesh(mesh, material, pose).tip_radius(radius_m).image();
      IdealRun with(image);
      IdealRun without(image);
      without.renderer().keep_nothing();
      Vector3d tip;
      do {
        tip = oracle.bounds().center() +
              random.in_box((test.side == host::MeshSide::kOutside ? 0.8 : 0.3) * oracle.bounds().sizes());
      } while (oracle.signed_distance(tip) < test.radius_m + 1e-4);
      Vector3d target = tip;
      double step_m = 0.0;
      with.restart(pose.position_m + pose.rotation * tip);
      without.restart(pose.position_m + pose.rotation * tip);
      for (int tick = 0; tick < ticks; ++tick) {
        if ((target - tip).norm() < 1e-9 || random.below(200) == 0) {
          target = next_target(oracle, tip, test.radius_m, random);
          constexpr double kSteps_m[] = {0.0, 5e-6, 2.5e-5, 2e-4, 2e-3};
          step_m = kSteps_m[random.below(5)] * random.uniform(0.2, 1.0);
        }
        const Vector3d way = target - tip;
        tip = way.norm() <= step_m ? target : Vector3d(tip + way * (step_m / way.norm()));
        const Felt& a = with.step(pose.position_m + pose.rotation * tip);
        const Felt& b = without.step(pose.position_m + pose.rotation * tip);
        if (a.contacts > 0) ++in_contact;
        if (a.force_N != b.force_N || a.god_object_m != b.god_object_m || a.contacts != b.contacts) ++differ;
      }
    }
  }
  figure("tip radius, lists of triangles: ticks in contact", static_cast<double>(in_contact), "");
  figure("tip radius, lists of triangles: ticks that differ", static_cast<double>(differ), "0");
  EXPECT_GT(in_contact, 24L * ticks / 5);
  EXPECT_EQ(differ, 0);
}

// What is kept from tick to tick of the place where a point rests, where faces cross, and of flights from there, changes no bit either.
TEST(Lists, ChangeNothingWhereMeshesCross) {
  constexpr int ticks = 8000;
  for (const char* file : {"OBJ/spider.obj", "OFF/Wuson.off", "glTF2/draco/2CylinderEngine.gltf"}) {
    const host::CompiledMesh mesh = host::compile_mesh(test_model(file, 0.1), {}, file);
    const std::vector<Vector3d> path = peer_path(
        MeshOracle(as_soup(mesh)), {.ticks = ticks, .noise_m = 2e-6, .seed = seed(), .lifts = true});
    const SceneImage image =
        SceneBuilder().mesh(mesh, {.static_friction = 0.6F, .dynamic_friction = 0.4F}).image();
    IdealRun with(image);
    IdealRun without(image);
    without.renderer().keep_nothing();
    with.restart(path.front());
    without.restart(path.front());
    long differ = 0;
    long in_contact = 0;
    for (const Vector3d& tip : path) {
      const Felt& a = with.step(tip);
      const Felt& b = without.step(tip);
      if (a.contacts > 1) ++in_contact;
      if (a.force_N != b.force_N || a.god_object_m != b.god_object_m || a.contacts != b.contacts) ++differ;
    }
    figure(std::string("lists, ") + file + ": ticks with several contacts", static_cast<double>(in_contact),
           "");
    figure(std::string("lists, ") + file + ": ticks that differ", static_cast<double>(differ), "0");
    EXPECT_GT(in_contact, ticks / 10);
    EXPECT_EQ(differ, 0);
  }
}

}  // namespace
}  // namespace thimble::test
