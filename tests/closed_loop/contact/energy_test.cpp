// Closed press-slide-release paths: the hand never gets back more energy than it put in, except for K T v x.
//
// A device holds each force for a tick, so even an ideal spring gives K (T v)^2 / 2 per tick: K T v x for a
// press to x and back, and T v / 2 times the total variation of the force when it rises and falls repeatedly.
// The work of the mean force of each step has no such part: its limit is K T v x with x the deepest point of
// the loop, for any length of slide.
#include <gtest/gtest.h>

#include <cmath>
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

}  // namespace
}  // namespace thimble::test
