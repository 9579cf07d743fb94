// Closed press-slide-release paths: the hand never gets back more energy than it put in, except for K T v x.
//
// A device holds each force for a tick, so even an ideal spring gives K (T v)^2 / 2 per tick: K T v x for a
// press to x and back, and T v / 2 times the total variation of the force when it rises and falls repeatedly.
// The work of the mean force of each step has no such part: its limit is K T v x with x the deepest point of
// the loop, for any length of slide.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

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

// Two to six solids about the origin, of stiffnesses that differ by up to thirty, touching and overlapping.
SceneImage random_solids(Random& random, bool friction) {
  SceneBuilder builder;
  const auto count = 2 + random.below(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    Material material;
    material.stiffness_N_m = static_cast<float>(100.0 * std::exp(random.uniform(0.0, 3.4)));
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

// Moves as a hand that feels its way: down until something holds, then about, between 0.3 and 3 mm deep, and back to where it began.
void feel_about(IdealRun& run, Random& random) {
  const Vector3d start(0.0, 0.0, 0.15);
  const double step_m = random.uniform(5e-6, 7.5e-5);  // 0.02 to 0.3 m/s
  run.restart(start);
  Vector3d tip = start;
  const auto go = [&](const Vector3d& direction) {
    tip += step_m * direction;
    run.step(tip);
  };
  const Vector3d aim = random.in_box({0.03, 0.03, 0.01});
  while (run.felt().contacts == 0 && (tip - aim).norm() > 0.001) go((aim - tip).normalized());
  Vector3d heading = random.direction();
  for (int i = 0; i < 3000; ++i) {
    if (i % 500 == 0) heading = random.direction();
    const Vector3d pull = run.felt().god_object_m - run.felt().tip_m;
    const double depth = pull.norm();
    Vector3d direction = heading;
    if (depth > 0.003) direction += 3.0 * pull / depth;
    if (run.felt().contacts == 0) direction += 0.7 * (aim - tip).normalized();
    go(direction.normalized());
  }
  const Vector3d out = run.felt().god_object_m + 0.5 * (run.felt().god_object_m - run.felt().tip_m);
  run.move(out, step_m);
  run.move(start, 2e-4);
}

TEST(Energy, NoPathOverSolidsOfUnlikeStiffnessGivesAny) {
  const char* wish = std::getenv("THIMBLE_ENERGY_SCENES");  // of the long check
  const int scenes = wish != nullptr ? std::stoi(wish) : 4 * kLoops;
  for (const bool friction : {false, true}) {
    Random random(friction ? 5 : 4);
    double worst = -1e9;
    int gives = 0, closed = 0;
    for (int scene = 0; scene < scenes; ++scene) {
      const SceneImage image = random_solids(random, friction);
      IdealRun run(image);
      for (int loop = 0; loop < 4; ++loop) {
        feel_about(run, random);
        if (run.felt().force_N.norm() != 0.0 || run.deepest_m() == 0.0) continue;
        ++closed;
        constexpr double kMostStiffness_N_m = 100.0 * 30.0;
        const double given =
            run.work_mean_force_J() / (kMostStiffness_N_m * run.longest_step_m() * run.deepest_m());
        worst = std::max(worst, given);
        gives += given > 1.0 ? 1 : 0;
      }
    }
    const std::string what = friction ? "unlike solids, friction: " : "unlike solids: ";
    figure(what + "closed loops", closed, "reported");
    figure(what + "most given over K T v x", worst, "1");
    figure(what + "loops that give energy", gives, "0");
    EXPECT_EQ(gives, 0) << what;
    EXPECT_GT(closed, 3 * scenes) << what;
  }
}

// Press on the soft box, slide to the stiff one, leave there: before, half of the difference of the stiffnesses times the depth squared.
TEST(Energy, FromASoftSolidToAStiffOneNothingIsGiven) {
  SceneBuilder builder;
  builder.box({0.02, 0.02, 0.01}, {.stiffness_N_m = 200.0F}, {Vector3d(-0.0099, 0.0, -0.005)});
  builder.box({0.02, 0.02, 0.01}, {.stiffness_N_m = 1500.0F}, {Vector3d(0.0099, 0.0, -0.005)});
  const SceneImage image = builder.image();
  IdealRun run(image);
  constexpr double kDepth_m = 0.003, kStep_m = 2.5e-5;
  for (const double from : {-1.0, 1.0}) {
    run.restart({from * 0.005, 0.0, 0.005});
    run.move({from * 0.005, 0.0, -kDepth_m}, kStep_m);
    run.move({-from * 0.005, 0.0, -kDepth_m}, kStep_m);
    run.move({-from * 0.005, 0.0, 0.005}, kStep_m);
    const std::string what = from < 0.0 ? "soft to stiff" : "stiff to soft";
    figure(what + ": given to the hand", 1e3 * run.work_mean_force_J(),
           "mJ; at most K T v x, 0.11 mJ. 5.85 mJ if the account ended with each solid");
    EXPECT_LT(run.work_mean_force_J(), 1500.0 * kStep_m * kDepth_m);
  }
}

}  // namespace
}  // namespace thimble::test
