// An adversary looks for a tick that exceeds its work: random scenes of solids, meshes that are closed, open or cross each other, and bodies, under
// motions that no hand makes. The judge is the theorem of docs/time.md. cortex.bound.* count the instructions of such scenes.
// THIMBLE_BOUND_SCENES sets the number of scenes, THIMBLE_BOUND_SEED the first seed, THIMBLE_BOUND_TICKS how long each motion is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "tests/closed_loop/bodies/compositions.h"
#include "tests/support/adversary.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

constexpr double kDefaultScenes = kUnderSanitizers ? 20 : 200;
constexpr double kDefaultTicks = 400;
// Scenes in which a stop is tried: each takes a board from power-on to armed.
constexpr std::uint64_t kMostStops = 1000;
constexpr double kSize_m = 0.05;

double bound_option(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}
std::uint64_t scenes() {
  return static_cast<std::uint64_t>(bound_option("THIMBLE_BOUND_SCENES", kDefaultScenes));
}
std::uint64_t first_seed() { return static_cast<std::uint64_t>(bound_option("THIMBLE_BOUND_SEED", 1)); }
std::size_t ticks() { return static_cast<std::size_t>(bound_option("THIMBLE_BOUND_TICKS", kDefaultTicks)); }

host::TriangleSoup some_mesh(Random& random) {
  const double size_m = random.uniform(0.2, 1.0) * kSize_m;
  switch (random.below(4)) {
    case 0:
      return icosphere(1 + static_cast<int>(random.below(4)), size_m);
    case 1:
      return sheet(2 * size_m, 2 + static_cast<int>(random.below(20)));
    case 2:
      return hostile_terrain(4 + static_cast<int>(random.below(12)), 0.1 * size_m, 0.05 * size_m,
                             random.bits());
    default: {  // closed parts through each other
      host::TriangleSoup all;
      for (std::uint64_t n = 3 + random.below(40); n > 0; --n) {
        const host::TriangleSoup part =
            box_mesh(size_m * (Vector3d::Constant(0.6) + random.in_box({0.4, 0.4, 0.4})), 1);
        const auto first = static_cast<std::uint32_t>(all.vertices_m.size());
        const Eigen::Quaterniond turn =
            Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), random.direction());
        const Vector3d at_m = 0.5 * size_m * random.direction();
        for (const Vector3d& v : part.vertices_m) all.vertices_m.push_back(at_m + turn * v);
        for (const auto& t : part.triangles)
          all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      }
      return all;
    }
  }
}

// Meshes are compiled once: that takes longer than the ticks of a scene. Scenes differ in which of them they have, where and of what.
const host::CompiledMesh& compiled_mesh(std::uint64_t number, double tip_radius_m, bool shaded) {
  static std::map<std::tuple<std::uint64_t, double, bool>, host::CompiledMesh> compiled;
  const auto [place, is_new] = compiled.try_emplace({number, tip_radius_m, shaded});
  if (is_new) {
    Random random(number);
    host::MeshOptions options;
    if (shaded) options.crease_deg = 40.0;
    if (tip_radius_m > 0.0) options.tip_radius_m = tip_radius_m;
    place->second = host::compile_mesh(some_mesh(random), options, "mesh " + std::to_string(number));
  }
  return place->second;
}

SceneImage fixed_scene(Random& random) {
  constexpr std::uint64_t kMeshes = 100;
  constexpr std::array kTipRadius_m{2e-4, 8e-4, 2e-3, 5e-3};
  SceneBuilder builder;
  const double tip_radius_m = random.below(3) == 0 ? kTipRadius_m.at(random.below(4)) : 0.0;
  builder.tip_radius(tip_radius_m);
  for (std::uint64_t n = 1 + random.below(24); n > 0; --n) {
    const Material material{.stiffness_N_m = static_cast<float>(random.uniform(200, 2000)),
                            .static_friction = static_cast<float>(random.uniform(0, 1)),
                            .dynamic_friction = 0.0F};
    const Pose pose{0.6 * kSize_m * random.in_box(Vector3d::Ones()),
                    Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), random.direction())};
    switch (random.below(5)) {
      case 0:
        builder.sphere(random.uniform(0.1, 1.0) * kSize_m, material, pose);
        break;
      case 1:
        builder.box(kSize_m * (Vector3d::Ones() + random.in_box({0.8, 0.8, 0.8})), material, pose);
        break;
      default:
        builder.mesh(compiled_mesh(random.below(kMeshes), tip_radius_m, random.below(3) == 0), material,
                     pose);
    }
  }
  return builder.image();
}

// Scenes with bodies take longest to compile, so there are 250 of them, each in turn under other motions.
const SceneImage& composed_scene(std::uint64_t number) {
  static Compositions compositions;
  static std::map<std::uint64_t, SceneImage> scenes;
  const std::uint64_t key = number % 250;
  if (const auto known = scenes.find(key); known != scenes.end()) return known->second;
  Random random(key);
  return scenes.emplace(key, scene_of(compositions.compose(random, 2 + random.below(5), true).members))
      .first->second;
}

struct Found {
  std::uint32_t over = 0;  // units beyond what a tick may do
  std::uint64_t over_seed = 0;
  std::uint64_t put_off = 0, ticks = 0;
  std::uint64_t stopped = 0;  // while something was put off

  void take(const control::Renderer& renderer, std::uint32_t units, std::uint64_t seed) {
    ++ticks;
    put_off += renderer.is_put_off() ? 1U : 0U;
    const std::uint32_t done = renderer.tick_work();
    if (done <= units + over) return;
    over = done - units;
    over_seed = seed;
  }
};

void attack(const SceneImage& image, Random& random, std::uint64_t seed, Found& found) {
  control::Renderer renderer;
  renderer.bind(image.view());
  const auto arms = 1 + static_cast<std::size_t>(random.below(2));
  const auto units = static_cast<std::uint32_t>(arms * (firmware::kLeastWork + random.below(400)));
  renderer.bound_work(units);
  for (const Attack kind : kAttacks) {
    std::array<std::vector<Vector3d>, control::kMaxArms> paths;
    for (std::size_t arm = 0; arm < arms; ++arm)
      paths.at(arm) = attack_path(kind, kSize_m, ticks(), random.bits());
    std::array<control::Tip, control::kMaxArms> tips;
    std::array<control::Touch, control::kMaxArms> touches;
    for (std::size_t i = 0; i < ticks(); ++i) {
      for (std::size_t arm = 0; arm < arms; ++arm) tips.at(arm).position_m = paths.at(arm)[i].cast<float>();
      renderer.tick(std::span(tips).first(arms), 1.0F / 4000.0F, std::span(touches).first(arms));
      found.take(renderer, units, seed);
      for (const control::Touch& touch : touches) ASSERT_TRUE(touch.force_N.allFinite()) << "seed " << seed;
    }
  }
  EXPECT_LE(renderer.counters().most_work, units + control::kMostBodyStepWork) << "seed " << seed;
}

// An e-stop and a stop act in the tick in which they come, whatever the tick before has put off.
void stop_while_put_off(const SceneImage& image, Random& random, std::uint64_t seed, Found& found) {
  firmware::Config config;
  config.work_units = firmware::kLeastWork;
  Bench bench(config, image.bytes().size() + firmware::SceneStore::kHeaderBytes + 64);
  bench.let_jump();
  ASSERT_EQ(bench.controller->load_scene(image.bytes()), firmware::StoreStatus::kOk);
  bench.home();
  bench.arm();
  const std::vector<Vector3d> path = attack_path(Attack::kDart, 0.8 * kSize_m, 400, random.bits());
  bench.move(path.front(), 100);
  for (const Vector3d& tip_m : path) {
    bench.place(tip_m);
    bench.tick();
    if (bench.mode() != Mode::kArmed) return;  // the motion was a fault
    if (!bench.controller->renderer().is_put_off()) continue;
    ++found.stopped;
    if (random.below(2) == 0) {
      bench.inputs.e_stop = true;
    } else {
      EXPECT_EQ(bench.controller->request(Command::kStop), 0);
    }
    bench.tick();
    EXPECT_EQ(bench.outputs.mode, Mode::kDamping) << "seed " << seed;
    return;
  }
}

TEST(WorkBound, NoSceneAndNoMotionExceedsIt) {
  Found found;
  for (std::uint64_t seed = first_seed(); seed < first_seed() + scenes(); ++seed) {
    Random random(seed);
    const bool composed = seed % 4 == 0;
    const std::optional<SceneImage> fixed =
        composed ? std::nullopt : std::optional<SceneImage>(fixed_scene(random));
    const SceneImage& image = composed ? composed_scene(seed / 4) : *fixed;
    attack(image, random, seed, found);
    if (seed < first_seed() + kMostStops) stop_while_put_off(image, random, seed, found);
    if (HasFailure()) break;
  }
  figure("units beyond the work of a tick, seed " + std::to_string(found.over_seed), found.over,
         std::to_string(control::kMostBodyStepWork));
  const double share = static_cast<double>(found.put_off) / static_cast<double>(found.ticks);
  figure("part of the ticks that put something off", share, "> 0.1");
  figure("stops while something was put off", static_cast<double>(found.stopped),
         "a third of the scenes, of " + std::to_string(kMostStops) + " at most");
  EXPECT_LE(found.over, control::kMostBodyStepWork);
  EXPECT_GT(share, 0.1);
  EXPECT_GE(3 * found.stopped, std::min(scenes(), kMostStops));
}

// The tip jumps through a body of many faces; the way over them would take the work of many ticks.
TEST(WorkBound, AfterAJumpTheGodObjectComesOverTheBody) {
  const SceneImage image =
      SceneBuilder().mesh(icosphere(7, kSize_m), {.static_friction = 0.6F, .dynamic_friction = 0.4F}).image();
  constexpr double kFlat_m = 3e-6;  // of a face below the ball
  control::Renderer renderer;
  renderer.bind(image.view());
  renderer.bound_work(300);
  control::Tip tip;
  control::Touch touch;
  int put_off = 0, in_contact = 0;
  double deepest_m = 0.0;
  for (const Vector3d& tip_m : attack_path(Attack::kTeleport, kSize_m, 8000, 1)) {
    tip.position_m = tip_m.cast<float>();
    renderer.tick(std::span(&tip, 1), 1.0F / 4000.0F, std::span(&touch, 1));
    if (renderer.is_put_off()) ++put_off;
    if (touch.contacts == 0) continue;
    ++in_contact;
    deepest_m = std::max(deepest_m, kSize_m - touch.god_object_m.cast<double>().norm());
  }
  figure("jumps through a fine ball: ticks in contact", in_contact, "> 4000");
  figure("jumps through a fine ball: ticks that put something off, %", put_off / 80.0, "40");
  figure("jumps through a fine ball: god object inside by, um", 1e6 * deepest_m, "3");
  EXPECT_GT(in_contact, 4000);
  EXPECT_LE(put_off, 3200);
  EXPECT_LE(deepest_m, kFlat_m);
}

// The longest run of ticks that put something off, and the part of all, while a tip is pressed into a ball of 20 480 triangles and jumps
// from side to side.
struct Pressed {
  int longest = 0;
  double part = 0;
};
Pressed press_deep(double tip_radius_m, std::uint32_t units) {
  SceneBuilder builder;
  builder.tip_radius(tip_radius_m);
  host::MeshOptions options;
  if (tip_radius_m > 0.0) options.tip_radius_m = tip_radius_m;
  builder.mesh(icosphere(5, kSize_m), {.static_friction = 0.6F, .dynamic_friction = 0.4F}, options);
  const SceneImage image = builder.image();
  control::Renderer renderer;
  renderer.bind(image.view());
  renderer.bound_work(units);
  control::Tip tip;
  control::Touch touch;
  Pressed found;
  int in_turn = 0, put_off = 0;
  const std::vector<Vector3d> path = attack_path(Attack::kPress, kSize_m, 8000, 1);
  for (const Vector3d& tip_m : path) {
    tip.position_m = tip_m.cast<float>();
    renderer.tick(std::span(&tip, 1), 1.0F / 4000.0F, std::span(&touch, 1));
    in_turn = renderer.is_put_off() ? in_turn + 1 : 0;
    put_off += renderer.is_put_off() ? 1 : 0;
    found.longest = std::max(found.longest, in_turn);
  }
  found.part = put_off / static_cast<double>(path.size());
  return found;
}

// The way over the faces from the stiction point to the place without friction can take all the work of a tick, and all that is near the way of
// a tip with a radius as well. The god object comes all the same.
TEST(WorkBound, UnderADeepPressTheGodObjectComes) {
  struct Case {
    double tip_radius_mm;
    std::uint32_t units;
  };
  for (const Case& c : {Case{0.0, firmware::kLeastWork}, Case{0.0, 300}, Case{0.5, firmware::kLeastWork},
                        Case{0.5, 300}, Case{1.9, 300}, Case{6.0, 300}}) {
    const Pressed found = press_deep(1e-3 * c.tip_radius_mm, c.units);
    const std::string with = std::to_string(c.tip_radius_mm) + " mm, " + std::to_string(c.units) + " units: ";
    figure(with + "ticks in turn that put something off", found.longest, "a tenth of a second: 400");
    figure(with + "part of the ticks", found.part, "0.1");
    EXPECT_LE(found.longest, 400) << with;
    EXPECT_LE(found.part, 0.1) << with;
  }
}

// A hand goes through bodies for some seconds, and stops wherever it is. From where the god object is then, the whole way to the tip takes more
// than the work of a tick in many places. The judge is the same tick without a bound.
struct Behind {
  int when_it_stops = 0, a_second_later = 0;
};
Behind behind_a_hand_that_stops(std::uint64_t seed, std::uint32_t units) {
  constexpr double kStep_m = 0.3 / 4000;
  constexpr int kMoving = 8000, kStill = 4000;
  constexpr float kNear_m = 1e-4F;
  Random random(seed);
  const double tip_radius_m = random.below(2) == 0 ? 0.0 : random.uniform(5e-4, 2e-3);
  SceneBuilder builder;
  builder.tip_radius(tip_radius_m);
  for (std::uint64_t n = 1 + random.below(3); n > 0; --n) {
    const Material material{.stiffness_N_m = 500, .static_friction = random.below(2) == 0 ? 0.0F : 0.6F};
    const Pose pose{0.4 * kSize_m * random.in_box(Vector3d::Ones()),
                    Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), random.direction())};
    const double size_m = random.uniform(0.4, 0.9) * kSize_m;
    host::MeshOptions options;
    if (tip_radius_m > 0.0) options.tip_radius_m = tip_radius_m;
    builder.mesh(random.below(2) == 0 ? icosphere(3, size_m) : torus(0.7 * size_m, 0.3 * size_m, 30, 14),
                 material, options, pose);
  }
  const SceneImage image = builder.image();
  control::Renderer renderer;
  renderer.bind(image.view());
  renderer.bound_work(units);
  Vector3d tip_m = 2.0 * kSize_m * random.direction(), goal_m = tip_m;
  const auto distance_m = [&](control::Renderer& by) {
    const control::Tip tip{.position_m = tip_m.cast<float>()};
    control::Touch touch;
    by.tick(std::span(&tip, 1), 1.0F / 4000.0F, std::span(&touch, 1));
    return (touch.god_object_m - tip.position_m).norm();
  };
  for (int i = 0; i < kMoving; ++i) {
    const Vector3d way_m = goal_m - tip_m;
    if (way_m.norm() < kStep_m) {
      goal_m = kSize_m * std::cbrt(random.uniform(0, 1)) * random.direction();
    } else {
      tip_m += kStep_m * way_m.normalized();
    }
    distance_m(renderer);
  }
  const auto is_behind = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) distance_m(renderer);
    control::Renderer unbound = renderer;
    unbound.bound_work(control::Work::kNoBound);
    for (int i = 0; i < 100; ++i) distance_m(unbound);
    return distance_m(renderer) - distance_m(unbound) > kNear_m;
  };
  const bool first = is_behind(0);
  return {first ? 1 : 0, is_behind(kStill) ? 1 : 0};
}

TEST(WorkBound, WhenTheHandStopsTheGodObjectComes) {
  constexpr int kScenes = kUnderSanitizers ? 8 : 80;
  constexpr std::uint32_t kUnits = 300;
  Behind all;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Behind one = behind_a_hand_that_stops(seed, kUnits);
    all.when_it_stops += one.when_it_stops;
    all.a_second_later += one.a_second_later;
  }
  figure("god objects that are behind when the hand stops", all.when_it_stops, "");
  constexpr int kMost = (kScenes + 9) / 10;  // in the corners of several meshes (docs/time.md)
  figure("of these a second later", all.a_second_later, std::to_string(kMost));
  EXPECT_LE(all.a_second_later, kMost);
}

}  // namespace
}  // namespace thimble::test
