// Tissue under a finger against the closed form of the three-parameter solid; its dimple and its energy.
#include "control/fields/tissue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kStiff = 400, kRelaxed = 150, kRecovery = 0.4, kRadius = 0.006;

SceneImage tissue_scene(const std::string& material = "") {
  const std::string text =
      R"({"thimble_scene":1,"name":"deform","objects":[{"name":"pad","shape":{"tissue":{"size_m":[0.1,0.08],)"
      R"("contact_radius_m":0.006,"relaxed_stiffness_N_m":150,"recovery_s":0.4}},"material":{"stiffness_N_m":400)" +
      material + "}}]}";
  return SceneImage(host::compile_scene_text(text, "deform", {}).image);
}

void hold(IdealRun& run, const Vector3d& p, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds * kRate_Hz)); ++i) run.step(p);
}

TEST(Tissue, PushesBackAtOnceAndRelaxesAsTheSolidSays) {
  IdealRun run(tissue_scene());
  run.step({0, 0, 0.0005});
  constexpr double kDepth = 0.008;
  const double at_once = run.step({0, 0, -kDepth}).force_N.z();
  figure("force at once, N", at_once, "1 % of K depth = " + std::to_string(kStiff * kDepth));
  EXPECT_NEAR(at_once, kStiff * kDepth, 0.01 * kStiff * kDepth);
  // c(t) = c_held (1 - exp(-t / t_relax)), t_relax = recovery K_relaxed / K, and F = K (d - c).
  const double t_relax = kRecovery * kRelaxed / kStiff;
  double worst = 0;
  for (int tick = 2; tick < 4000; ++tick) {
    const double t = tick / kRate_Hz;
    const double crept = kDepth * (1 - kRelaxed / kStiff) * (1 - std::exp(-t / t_relax));
    const double expected = kStiff * (kDepth - crept);
    worst = std::max(worst, std::abs(run.step({0, 0, -kDepth}).force_N.z() - expected) / expected);
  }
  figure("relaxing for 1 s: worst difference from the closed form", worst, "1 %");
  EXPECT_LT(worst, 0.01);
  hold(run, {0, 0, -kDepth}, 2.0);
  EXPECT_NEAR(run.felt().force_N.z(), kRelaxed * kDepth, 0.01 * kRelaxed * kDepth);
  EXPECT_LT(run.felt().force_N.head<2>().norm(), 1e-6);
}

// The depth at which a tip that comes down feels the surface first.
double surface_at(IdealRun& run, double x, double y, double step_m = 1e-6) {
  for (double z = 0.0; z > -0.02; z -= step_m) {
    if (run.step({x, y, z}).contacts > 0) return -z;
  }
  return 0.02;
}

TEST(Tissue, TheDimpleComesBackWithItsTimeConstant) {
  constexpr double kDepth = 0.008;
  const double left = kDepth * (1 - kRelaxed / kStiff);
  double worst = 0;
  for (const double wait : {0.1, 0.4, 0.8, 1.2}) {
    IdealRun run(tissue_scene());
    run.step({0, 0, 0.001});
    hold(run, {0, 0, -kDepth}, 3.0);
    run.step({0, 0, 0.001});  // let go at once
    EXPECT_EQ(run.felt().force_N.norm(), 0.0);
    hold(run, {0, 0, 0.001}, wait);
    const double found = surface_at(run, 0, 0, 2e-5) - 1e-5;  // the middle of the step that met it
    const double looked = found / 2e-5 / kRate_Hz;            // it comes back while it is looked for
    const double expected = left * std::exp(-(wait + looked) / kRecovery);
    worst = std::max(worst, (std::abs(found - expected) - 1e-5) / expected);
    figure("surface met again after " + std::to_string(wait) + " s, mm", 1e3 * found,
           "1 % and half a step of 0.02 of " + std::to_string(1e3 * expected));
  }
  EXPECT_LT(worst, 0.01);
}

TEST(Tissue, TheDimpleHasTheShapeOfAFlatPunch) {
  double worst = 0;
  for (const double r : {0.0, 0.003, 0.006, 0.008, 0.012, 0.03}) {
    const double expected = r <= kRadius ? 1.0 : 2 / std::numbers::pi * std::asin(kRadius / r);
    worst = std::max(
        worst,
        std::abs(static_cast<double>(control::dimple_depth_m(0.005F, 0.006F, static_cast<float>(r))) / 0.005 -
                 expected));
    // And that is where a tip beside the dimple meets the surface.
    IdealRun run(tissue_scene());
    run.step({0, 0, 0.001});
    hold(run, {0, 0, -0.008}, 3.0);
    run.step({0, 0, 0.001});
    const double found = surface_at(run, r, 0, 2e-5);
    const double middle = 0.008 * (1 - kRelaxed / kStiff) * std::exp(-found / 2e-5 / kRate_Hz / kRecovery);
    EXPECT_NEAR(found, middle * expected, 0.02 * middle) << r;
  }
  figure("worst difference from (2 / pi) asin(a / r)", worst, "1e-6");
  EXPECT_LT(worst, 1e-6);
}

TEST(Tissue, TheDimpleFollowsASlide) {
  IdealRun run(tissue_scene());
  run.step({-0.03, 0, 0.001});
  hold(run, {-0.03, 0, -0.008}, 2.0);
  const double before = run.felt().force_N.z();
  double worst = 0;
  for (double x = -0.03; x < 0.03; x += 2e-5)
    worst = std::max(worst, std::abs(run.step({x, 0, -0.008}).force_N.z() - before));
  figure("change of force over a slide of 60 mm, N", worst, "1 % of " + std::to_string(before));
  EXPECT_LT(worst, 0.01 * before);
  run.step({0.03, 0, 0.001});
  EXPECT_GT(surface_at(run, 0.03, 0, 2e-5), 0.004) << "the dimple is where the tip let go";

  const SceneImage rough =
      tissue_scene(R"(,"static_friction":0.5,"dynamic_friction":0.5,"friction_mode":"steady")");
  IdealRun drag(rough);
  drag.step({-0.03, 0, 0.001});
  hold(drag, {-0.03, 0, -0.008}, 3.0);
  drag.move({0.0, 0, -0.008}, 1e-5);
  const Vector3d force = drag.felt().force_N;
  figure("friction over normal force while it slides", -force.x() / force.z(), "0.5 +- 1 %");
  EXPECT_NEAR(-force.x() / force.z(), 0.5, 0.005);
}

TEST(Tissue, IsFeltFromAboveOnly) {
  IdealRun run(tissue_scene());
  EXPECT_EQ(run.step({0, 0, -0.01}).force_N.norm(), 0.0) << "first seen inside";
  EXPECT_EQ(run.move({0, 0, -0.02}, 1e-4).force_N.norm(), 0.0);
  run.move({0, 0, 0.001}, 1e-4);
  EXPECT_GT(run.move({0, 0, -0.002}, 1e-4).force_N.z(), 0.5);
  EXPECT_EQ(run.move({0.06, 0, -0.002}, 1e-4).force_N.norm(), 0.0) << "off the edge";
  EXPECT_EQ(run.move({0, 0, -0.002}, 1e-4).force_N.norm(), 0.0) << "from the side";
}

TEST(Tissue, ClosedLoopsGiveNoEnergy) {
  double most = -1, longest = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const SceneImage scene = tissue_scene(seed % 2 == 0 ? R"(,"static_friction":0.6,"dynamic_friction":0.4)"
                                                        : R"(,"damping_N_s_m":1)");
    IdealRun run(scene);
    Vector3d p(0, 0, 0.001);
    run.step(p);
    for (int leg = 0; leg < 80; ++leg) {
      const Vector3d next(random.uniform(-0.06, 0.06), random.uniform(-0.05, 0.05),
                          random.uniform(-0.012, 0.004));
      const Vector3d to = random.below(2) == 0 ? next : Vector3d(p.x(), p.y(), next.z());
      const double step = random.uniform(2e-6, 4e-5);
      const int steps = static_cast<int>((to - p).norm() / step) + 1;
      const Vector3d from = p;
      for (int i = 1; i <= steps; ++i) {
        p = from + (to - from) * (1.0 * i / steps);
        run.step(p);
        most = std::max(most, run.work_mean_force_J());
      }
      if (random.below(4) == 0) hold(run, p, random.uniform(0.01, 0.3));
      longest = std::max(longest, run.longest_step_m());
    }
  }
  const double slack = kStiff * longest * longest;
  figure("most energy the hand ever had from the tissue, J", most,
         "at most K step^2 = " + std::to_string(slack));
  EXPECT_LE(most, slack);
}

}  // namespace
}  // namespace thimble::test
