// Closed press-slide-release paths: the hand never gets back more energy than it put in, except for K T v x.
//
// A device holds each force for a tick, so even an ideal spring gives K (T v)^2 / 2 per tick: K T v x for a
// press to x and back, and T v / 2 times the total variation of the force when it rises and falls repeatedly.
// The work of the mean force of each step has no such part: its limit is K T v x with x the deepest point of
// the loop, for any length of slide.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

constexpr int kLoops = kUnderSanitizers ? 6 : 60;

struct Solid {
  std::string name;
  std::function<void(SceneBuilder&, const Material&)> add;
  // A free point a few mm above the surface, and the point on the surface under it.
  std::function<std::pair<Vector3d, Vector3d>(Random&)> start;
  double slide_m = 0.01;
};

std::function<std::pair<Vector3d, Vector3d>(Random&)> above_mesh(const host::TriangleSoup& soup) {
  return [soup](Random& random) {
    const MeshOracle oracle(soup);
    for (;;) {
      const auto triangle = static_cast<std::uint32_t>(random.below(oracle.size()));
      const Vector3d centre =
          (oracle.corner(triangle, 0) + oracle.corner(triangle, 1) + oracle.corner(triangle, 2)) / 3.0;
      const Vector3d free = centre + 0.004 * oracle.normal(triangle);
      if (!oracle.crosses(centre + 1e-9 * oracle.normal(triangle), free)) return std::pair(free, centre);
    }
  };
}

std::vector<Solid> bodies() {
  const auto on_plane = [](Random& random) {
    const Vector3d p = random.in_box({0.02, 0.02, 0.0});
    return std::pair(Vector3d(p + Vector3d(0.0, 0.0, 0.004)), p);
  };
  const auto on_sphere = [](Random& random) {
    const Vector3d out = random.direction();
    return std::pair(Vector3d(0.034 * out), Vector3d(0.03 * out));
  };
  std::vector<Solid> result = {
      {"plane", [](SceneBuilder& b, const Material& m) { b.plane(Vector3d::UnitZ(), 0.0, m); }, on_plane},
      {"sphere", [](SceneBuilder& b, const Material& m) { b.sphere(0.03, m); }, on_sphere},
      {"box",
       [](SceneBuilder& b, const Material& m) {
         b.box({0.03, 0.03, 0.03}, m);
       },
       above_mesh(box_mesh({0.03, 0.03, 0.03}, 4))},
      {"cylinder", [](SceneBuilder& b, const Material& m) { b.cylinder(0.02, 0.02, m); },
       [](Random& random) {
         const double around = random.uniform(0.0, 6.28);
         const Vector3d out(std::cos(around), std::sin(around), 0.0);
         const Vector3d up(0.0, 0.0, random.uniform(-0.018, 0.018));
         return std::pair(Vector3d(0.024 * out + up), Vector3d(0.02 * out + up));
       }},
      {"capsule", [](SceneBuilder& b, const Material& m) { b.capsule(0.02, 0.02, m); },
       [](Random& random) {
         const Vector3d out = random.direction();
         const Vector3d centre(0.0, 0.0, std::copysign(0.02, out.z()));
         return std::pair(Vector3d(centre + 0.024 * out), Vector3d(centre + 0.02 * out));
       }},
      {"cone", [](SceneBuilder& b, const Material& m) { b.cone(0.02, 0.04, m); },
       [](Random& random) {
         const double around = random.uniform(0.0, 6.28);
         const Vector3d out(std::cos(around), std::sin(around), 0.0);
         const Vector3d normal = (2.0 * out + Vector3d::UnitZ()) / std::sqrt(5.0);
         const double down = random.uniform(0.2, 0.8);  // of the way from the apex to the rim
         const Vector3d p = 0.02 * down * out + Vector3d(0.0, 0.0, 0.03 - 0.04 * down);
         return std::pair(Vector3d(p + 0.004 * normal), p);
       }},
      {"groove of two planes",
       [](SceneBuilder& b, const Material& m) {
         b.plane(Vector3d(1.0, 0.0, 1.0), 0.0, m).plane(Vector3d(-1.0, 0.0, 1.0), 0.0, m);
       },
       [](Random& random) {
         const Vector3d p(0.0, random.uniform(-0.01, 0.01), 0.0);
         return std::pair(Vector3d(p + Vector3d(random.uniform(-0.002, 0.002), 0.0, 0.005)), p);
       }}};
  const auto add_mesh = [&](const std::string& name, const host::TriangleSoup& soup,
                            host::MeshOptions options) {
    const auto compiled = std::make_shared<host::CompiledMesh>(host::compile_mesh(soup, options, name));
    result.push_back({name, [compiled](SceneBuilder& b, const Material& m) { b.mesh(*compiled, m); },
                      above_mesh(as_soup(*compiled))});
  };
  const host::MeshOptions shaded = {host::MeshSide::kOutside, 60.0};
  add_mesh("icosphere 80", icosphere(1, 0.03), {});
  add_mesh("icosphere 1280", icosphere(3, 0.03), {});
  add_mesh("icosphere 80, shaded", icosphere(1, 0.03), shaded);
  add_mesh("icosphere 1280, shaded", icosphere(3, 0.03), shaded);
  add_mesh("icosphere 1280 from inside, shaded", icosphere(3, 0.03), {host::MeshSide::kInside, 60.0});
  add_mesh("uv sphere, shaded", uv_sphere(48, 24, 0.03), shaded);
  add_mesh("torus", torus(0.03, 0.012, 24, 12), {});
  add_mesh("torus, shaded", torus(0.03, 0.012, 24, 12), shaded);
  add_mesh("box mesh, creased", box_mesh({0.03, 0.03, 0.03}, 4), {host::MeshSide::kOutside, 40.0});
  add_mesh("knife", knife(20.0, 0.03, 0.05, 6), {});
  add_mesh("groove", v_groove(90.0, 0.01, 0.05, 6), {});
  add_mesh("terrain", hostile_terrain(20, 0.002, 0.002, 5), {});
  add_mesh("terrain, shaded", hostile_terrain(20, 0.002, 0.002, 5), shaded);
  add_mesh("sheet", sheet(0.06, 9), {});
  return result;
}

// One loop: press, wander under the surface about where it was met, release on the same side, back to the
// start.
void press_slide_release(IdealRun& run, Random& random, const Vector3d& free, const Vector3d& surface,
                         double slide_m) {
  const Vector3d n = (free - surface).normalized();
  const double step_m = random.uniform(5e-6, 7.5e-5);  // 0.02 to 0.3 m/s
  run.restart(free);
  run.move(surface - random.uniform(0.0005, 0.003) * n, step_m);
  for (int leg = 0; leg < 6; ++leg) {
    Vector3d across = slide_m * random.in_box(Vector3d::Ones());
    across -= n * n.dot(across);
    run.move(surface + across - random.uniform(0.0003, 0.003) * n, step_m);
  }
  run.move(surface - 0.001 * n, step_m);
  run.move(free, step_m);
}

TEST(Energy, AClosedLoopNeverGivesMoreThanKTvx) {
  for (const Solid& body : bodies()) {
    for (const float friction : {0.0F, 0.6F}) {
      for (const scene::FrictionMode mode : {scene::FrictionMode::StickSlip, scene::FrictionMode::Steady}) {
        if (friction == 0.0F && mode == scene::FrictionMode::Steady) continue;
        SceneBuilder builder;
        body.add(builder,
                 {.static_friction = friction, .dynamic_friction = friction / 1.5F, .friction_mode = mode});
        const SceneImage image = builder.image();
        IdealRun run(image);
        Random random(12);
        double worst_held = -1e9;
        double worst_mean = -1e9;
        int gives = 0;
        int open = 0;
        for (int loop = 0; loop < kLoops; ++loop) {
          const auto [free, surface] = body.start(random);
          press_slide_release(run, random, free, surface, body.slide_m);
          if (run.felt().force_N.norm() != 0.0) {
            ++open;  // the god object was left behind a ridge or an edge: the loop is not closed
            continue;
          }
          const double held = run.work_on_hand_J() / (run.longest_step_m() * 0.5 * run.force_variation_N());
          const double mean =
              run.work_mean_force_J() / (kDefaultStiffness_N_m * run.longest_step_m() * run.deepest_m());
          worst_held = std::max(worst_held, held);
          worst_mean = std::max(worst_mean, mean);
          if (held > 1.0 || mean > 1.0) ++gives;
        }
        const std::string what =
            "energy, " + body.name +
            (friction == 0.0F ? "" : std::string(", ") + scene::EnumNameFrictionMode(mode)) + ": ";
        figure(what + "most given over K T v x", worst_mean, "1");
        figure(what + "the same with the force held, over its own bound", worst_held, "1");
        figure(what + "loops that give energy, of " + std::to_string(kLoops), gives, "0");
        EXPECT_EQ(gives, 0) << what;
        EXPECT_LT(open, kLoops / 2) << what;
      }
    }
  }
}

double random_stiffness_N_m(Random& random) { return 100.0 * std::exp(random.uniform(0.0, 3.4)); }

// Two to six solids about the origin, of stiffnesses that differ by up to thirty, touching and overlapping.
SceneImage random_solids(Random& random, bool friction) {
  SceneBuilder builder;
  const auto count = 2 + random.below(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    Material material;
    material.stiffness_N_m = static_cast<float>(random_stiffness_N_m(random));
    if (friction) {
      material.static_friction = static_cast<float>(random.uniform(0.0, 0.8));
      material.dynamic_friction = 0.7F * material.static_friction;
    }
    const Pose pose{random.in_box({0.025, 0.025, 0.025}),
                    Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(0.0, 6.28), random.direction()))};
    const double a = random.uniform(0.01, 0.03), b = random.uniform(0.01, 0.03);
    switch (random.below(5)) {
      case 0:
        builder.sphere(a, material, pose);
        break;
      case 1:
        builder.cylinder(a, b, material, pose);
        break;
      case 2:
        builder.capsule(a, b, material, pose);
        break;
      case 3:
        builder.plane(pose.rotation * Vector3d::UnitZ() + 1.5 * Vector3d::UnitZ(), random.uniform(-0.02, 0.0),
                      material);
        break;
      default:
        builder.box({a, b, random.uniform(0.01, 0.03)}, material, pose);
    }
  }
  return builder.image();
}

// From the tick in which the tip meets something to the one in which the god object is at the tip again.
struct Touched {
  double given_J = 0.0;  // to the hand
  double deepest_m = 0.0;
  double largest_N = 0.0;
  double step_m = 0.0;  // the longest: the one that leads to the surface can be a step in free space
};

constexpr double kAtTip_m = 1e-8;  // the god object, but for rounding

// Moves as a hand that feels its way: down until something holds, then about, between 0.3 and 3 mm deep, and back to where it began.
// touched(): called after each touch.
void feel_about(IdealRun& run, Random& random, const std::function<void(const Touched&)>& touched) {
  constexpr double kFreeStep_m = 2e-4;
  const Vector3d start(0.0, 0.0, 0.15);
  const double step_m = random.uniform(5e-6, 7.5e-5);  // 0.02 to 0.3 m/s
  run.restart(start);
  Touched now;
  double before_J = 0.0;
  const auto depth_m = [&] { return (run.felt().god_object_m - run.felt().tip_m).norm(); };
  const auto go = [&](const Vector3d& direction, double length_m) {
    run.step(run.felt().tip_m + length_m * direction);
    now.given_J += run.work_mean_force_J() - before_J;
    before_J = run.work_mean_force_J();
    now.deepest_m = std::max(now.deepest_m, depth_m());
    now.largest_N = std::max(now.largest_N, run.felt().force_N.norm());
    if (depth_m() >= kAtTip_m) now.step_m = std::max(now.step_m, length_m);
    if (depth_m() < kAtTip_m && now.deepest_m >= kAtTip_m) {
      touched(now);
      now = {};
    }
  };
  const Vector3d aim = random.in_box({0.03, 0.03, 0.01});
  while (run.felt().contacts == 0 && (run.felt().tip_m - aim).norm() > 0.001)
    go((aim - run.felt().tip_m).normalized(), step_m);
  Vector3d heading = random.direction();
  for (int i = 0; i < 3000; ++i) {
    if (i % 500 == 0) heading = random.direction();
    const Vector3d pull = run.felt().god_object_m - run.felt().tip_m;
    const double depth = pull.norm();
    Vector3d direction = heading;
    if (depth > 0.003) direction += 3.0 * pull / depth;
    if (run.felt().contacts == 0) direction += 0.7 * (aim - run.felt().tip_m).normalized();
    go(direction.normalized(), step_m);
  }
  const Vector3d out = run.felt().god_object_m + 0.5 * (run.felt().god_object_m - run.felt().tip_m);
  constexpr double kThere_m = 1e-7;  // a few roundings of a float at 0.15 m
  for (const Vector3d& to : {out, start}) {
    for (;;) {
      const Vector3d left = to - run.felt().tip_m;
      if (left.norm() < kThere_m) break;
      go(left.normalized(), std::min(left.norm(), depth_m() < kAtTip_m ? kFreeStep_m : step_m));
    }
  }
}

std::string row(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "[" : ", ") + std::to_string(number);
  return text + "]";
}

std::string row(const Vector3d& v) { return row({v.x(), v.y(), v.z()}); }

// A surface of the kinds that a scene file can have; its stiffness is nowhere above 100 exp(3.4).
std::string random_surface(Random& random, bool friction, bool takes_texture) {
  const double holds = friction ? random.uniform(0.0, 0.8) : 0.0;
  std::string text = R"("material": {"stiffness_N_m": )" + std::to_string(random_stiffness_N_m(random)) +
                     R"(, "static_friction": )" + std::to_string(holds) + R"(, "dynamic_friction": )" +
                     std::to_string(0.7 * holds);
  const auto effect = random.below(3);
  if (effect == 0 && takes_texture) {
    constexpr std::array kKinds = {"height", "normal", "lateral"};
    constexpr std::array kPatterns = {"cos_cos", "ridges", "noise"};
    text += R"(, "texture": {"kind": ")" + std::string(kKinds[random.below(3)]) + R"(", "pattern": ")" +
            kPatterns[random.below(3)] + R"(", "tile_m": [0.004, 0.005], "height_m": )" +
            std::to_string(random.uniform(1e-5, 5e-4)) + "}";
  } else if (effect == 1) {
    std::string rows;
    for (int i = 0; i < 4; ++i) {
      rows += (i == 0 ? "[" : ", ") + row({random_stiffness_N_m(random), random_stiffness_N_m(random),
                                           random_stiffness_N_m(random), random_stiffness_N_m(random)});
    }
    text += R"(, "stiffness_map": {"stiffness_N_m": )" + rows + R"(], "cell_m": 0.01, "origin_m": )" +
            row({-0.015, -0.015, 0.0}) + R"(, "conservative": )" + (random.below(2) == 0 ? "true" : "false") +
            "}";
  }
  return text + "}";
}

// The same with shaded meshes and height fields, textures and stiffness maps. `folder` has ball.obj, torus.obj and hills.csv.
SceneImage random_surfaces(Random& random, bool friction, const TemporaryFolder& folder) {
  std::string objects;
  const auto count = 2 + random.below(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    const double a = random.uniform(0.01, 0.03), b = random.uniform(0.01, 0.03);
    const auto kind = random.below(8);
    bool takes_texture = true;
    std::string shape;
    Vector3d at_m = random.in_box({0.025, 0.025, 0.025});
    switch (kind) {
      case 0:
        shape = R"("sphere": {"radius_m": )" + std::to_string(a) + "}";
        takes_texture = false;
        break;
      case 1:
        shape = R"("cylinder": {"radius_m": )" + std::to_string(a) + R"(, "height_m": )" + std::to_string(b) +
                "}";
        break;
      case 2:
        shape = R"("plane": {"normal": )" + row(0.5 * random.direction() + Vector3d::UnitZ()) + "}";
        at_m.z() -= 0.02;
        break;
      case 3:
        shape = R"("box": {"size_m": )" + row({a, b, random.uniform(0.01, 0.03)}) + "}";
        break;
      case 4:
        shape = R"("height_field": {"file": "hills.csv", "size_m": [0.06, 0.06], "height_m": )" +
                std::to_string(random.uniform(0.0002, 0.002)) + "}";
        break;
      default:
        shape = R"("mesh": {"file": ")" + std::string(kind == 5 ? "torus.obj" : "ball.obj") +
                R"(", "crease_deg": 60, "scale": )" + std::to_string(random.uniform(0.3, 1.0)) + "}";
    }
    objects +=
        (i == 0 ? R"({"name": ")" : R"(, {"name": ")") + std::to_string(i) + R"(", "shape": {)" + shape +
        R"(}, "pose": {"position_m": )" + row(at_m) + R"(, "rotation_deg": )" +
        (kind == 2 || kind == 4 ? row({0.0, 0.0, 0.0}) : row(180.0 * random.in_box(Vector3d::Ones()))) +
        "}, " + random_surface(random, friction, takes_texture) + "}";
  }
  const std::string text = R"({"thimble_scene": 1, "name": "test", "objects": [)" + objects + "]}";
  return SceneImage(host::compile_scene_text(text, "test.scene.json", folder.path()).image);
}

std::uint64_t wish(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::stoull(text);
}

// scene_of(random, friction) makes the scenes. Each has a seed of its own, so that THIMBLE_ENERGY_SEED and THIMBLE_ENERGY_SCENES=1 repeat
// one. The bound of a touch is the stated one, K T v x; a texture can push harder than K x, and then it is T v times its largest force.
void expect_no_loop_gives(const std::string& name, std::uint64_t scenes,
                          const std::function<SceneImage(Random&, bool)>& scene_of) {
  scenes = wish("THIMBLE_ENERGY_SCENES", scenes);
  const std::uint64_t first = wish("THIMBLE_ENERGY_SEED", 1);
  figure(name + ": seed", static_cast<double>(first), "reported; THIMBLE_ENERGY_SEED");
  for (const bool friction : {false, true}) {
    double worst = -1e9;
    std::uint64_t worst_seed = 0, gives = 0, closed = 0, touches = 0;
    for (std::uint64_t seed = first; seed < first + scenes; ++seed) {
      Random random(2 * seed + (friction ? 1 : 0));
      const SceneImage image = scene_of(random, friction);
      IdealRun run(image);
      for (int loop = 0; loop < 4; ++loop) {
        feel_about(run, random, [&](const Touched& touch) {
          constexpr double kMostStiffness_N_m = 100.0 * 30.0;
          const double most_J =
              touch.step_m * std::max(kMostStiffness_N_m * touch.deepest_m, touch.largest_N);
          const double given = touch.given_J / most_J;
          if (given > worst) worst_seed = seed;
          worst = std::max(worst, given);
          gives += given > 1.0 ? 1 : 0;
          ++touches;
        });
        if (run.felt().force_N.norm() == 0.0 && run.deepest_m() > 0.0) ++closed;
      }
    }
    const std::string what = name + (friction ? ", friction: " : ": ");
    figure(what + "closed loops", static_cast<double>(closed), "reported");
    figure(what + "touches", static_cast<double>(touches), "reported");
    figure(what + "most given in a touch, over K T v x", worst, "1");
    figure(what + "the seed of that one", static_cast<double>(worst_seed), "reported");
    figure(what + "touches that give energy", static_cast<double>(gives), "0");
    EXPECT_EQ(gives, 0U) << what;
    EXPECT_GT(closed, 3 * scenes) << what;
  }
}

TEST(Energy, NoPathOverSolidsOfUnlikeStiffnessGivesAny) {
  expect_no_loop_gives("unlike solids", std::uint64_t{4} * kLoops, random_solids);
}

TEST(Energy, NoPathOverUnlikeShadedTexturedAndMappedSolidsGivesAny) {
  const TemporaryFolder folder;
  write_obj(icosphere(2, 0.03), 1.0, folder.path() / "ball.obj");
  write_obj(torus(0.025, 0.01, 16, 10), 1.0, folder.path() / "torus.obj");
  folder.write("hills.csv", "0,3,1,6,2\n5,0,4,1,3\n2,6,0,5,1\n4,1,5,0,6\n0,3,2,4,1\n");
  expect_no_loop_gives("unlike surfaces", kLoops, [&](Random& random, bool friction) {
    return random_surfaces(random, friction, folder);
  });
}

// Press on the soft box, slide to the stiff one, leave there: before, half of the difference of the stiffnesses times the depth squared.
// beyond_m: how far from the seam it leaves.
TEST(Energy, FromASoftSolidToAStiffOneNothingIsGiven) {
  SceneBuilder builder;
  builder.box({0.02, 0.02, 0.01}, {.stiffness_N_m = 200.0F}, {Vector3d(-0.0099, 0.0, -0.005)});
  builder.box({0.02, 0.02, 0.01}, {.stiffness_N_m = 1500.0F}, {Vector3d(0.0099, 0.0, -0.005)});
  const SceneImage image = builder.image();
  IdealRun run(image);
  constexpr double kDepth_m = 0.003, kStep_m = 2.5e-5;
  for (const double beyond_m : {0.0002, 0.005}) {
    for (const double from : {-1.0, 1.0}) {
      run.restart({from * 0.005, 0.0, 0.005});
      run.move({from * 0.005, 0.0, -kDepth_m}, kStep_m);
      run.move({-from * beyond_m, 0.0, -kDepth_m}, kStep_m);
      run.move({-from * beyond_m, 0.0, 0.005}, kStep_m);
      const std::string what = std::string(from < 0.0 ? "soft to stiff, " : "stiff to soft, ") +
                               std::to_string(std::lround(1e6 * beyond_m)) + " um beyond the seam";
      figure(what + ": given to the hand", 1e3 * run.work_mean_force_J(),
             "mJ; at most K T v x, 0.11 mJ. 5.85 mJ if the account ended with each solid");
      EXPECT_LT(run.work_mean_force_J(), 1500.0 * kStep_m * kDepth_m);
    }
  }
}

}  // namespace
}  // namespace thimble::test
