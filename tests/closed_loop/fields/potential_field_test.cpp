// Potential fields on the board (paper, section 5.1): closed paths do no work, a hard inclusion has an
// effect, the force is continuous.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/closed_loop/fields/support.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

// Concentric spheres with the core held at a depth of 20 mm: closed form everywhere between.
constexpr double kOuter_m = 0.04;
constexpr double kInner_m = 0.015;
const std::string kSpheres = R"("potential_field": {"shape": {"sphere": {"radius_m": 0.04}}, "step_m": 0.002,
    "inclusions": [{"shape": {"sphere": {"radius_m": 0.015}}, "depth_m": 0.02}]})";
const std::string kSpheresOfEnergy =
    R"("potential_field": {"shape": {"sphere": {"radius_m": 0.04}}, "step_m": 0.002,
    "law": "energy", "inclusions": [{"shape": {"sphere": {"radius_m": 0.015}}, "potential_J": 0.02}]})";
// Soft, with a hard lump off its middle.
const std::string kLump =
    R"("potential_field": {"shape": {"box": {"size_m": [0.08, 0.06, 0.04]}}, "step_m": 0.002,
    "source_per_m": 50, "inclusions": [{"shape": {"sphere": {"radius_m": 0.006}}, "pose": {"position_m": [0.01, 0, 0.006]},
    "depth_m": 0.02}]})";

// u and its slope along the radius, inwards.
struct Radial {
  double u;
  double slope;
};
Radial between_spheres(double r) {
  const double scale = 0.02 / (1.0 / kInner_m - 1.0 / kOuter_m);
  return {scale * (1.0 / r - 1.0 / kOuter_m), scale / (r * r)};
}

TEST(PotentialField, TheForceIsTheClosedForms) {
  constexpr double kGrid_m = 0.002;
  for (const bool energy : {false, true}) {
    const SceneImage image = one_object(energy ? kSpheresOfEnergy : kSpheres, "\"stiffness_N_m\": 500",
                                        R"("position_m": [0.02, 0, -0.01], "rotation_deg": [10, 20, 30])");
    IdealRun run(image);
    Random random(21);
    double worst = 0;          // farther than a step from the core
    double worst_at_core = 0;  // nearer
    double worst_sideways = 0;
    double most_N = 0;
    for (int i = 0; i < 5000; ++i) {
      const Felt& felt = run.step(Vector3d(0.02, 0, -0.01) +
                                  random.uniform(kInner_m, kOuter_m - 1.0e-5) * random.direction());
      const Vector3d arm = felt.tip_m - Vector3d(0.02, 0, -0.01);
      const Radial at = between_spheres(arm.norm());
      const double expected = energy ? at.slope : kStiffness_N_m * at.u * at.slope;
      most_N = std::max(most_N, expected);
      const double off_N = std::abs(felt.force_N.norm() - expected);
      (arm.norm() > kInner_m + kGrid_m ? worst : worst_at_core) =
          std::max(arm.norm() > kInner_m + kGrid_m ? worst : worst_at_core, off_N);
      worst_sideways = std::max(worst_sideways, felt.force_N.cross(arm.normalized()).norm());
    }
    const std::string name = energy ? "energy" : "spring";
    EXPECT_LT(
        figure(name + ", between spheres: worst error of the force, of the largest", worst / most_N, "0.01"),
        0.01);
    EXPECT_LT(figure(name + ", within a step of the core: the same", worst_at_core / most_N, "0.04"), 0.04);
    EXPECT_LT(figure(name + ", between spheres: most force off the radius, of the largest",
                     worst_sideways / most_N, "0.02"),
              0.02);
    EXPECT_EQ(run.step({0.02, 0, -0.01 + kOuter_m + 2.0e-4}).force_N.norm(), 0.0);
    EXPECT_EQ(run.step({0.5, 0, 0}).force_N.norm(), 0.0);
  }
}

TEST(PotentialField, ClosedPathsDoNoWork) {
  struct Case {
    std::string name;
    std::string shape;
    Vector3d half_m;  // where the loops go: inside and through the surface
    double
        limit;  // of the largest energy stored on the way; the path's steps round the corner at the surface
  };
  for (const Case& test : {Case{"spheres, spring", kSpheres, Vector3d::Constant(0.03), 1e-5},
                           Case{"lump, spring", kLump, Vector3d(0.045, 0.035, 0.025), 1e-5},
                           Case{"spheres, energy", kSpheresOfEnergy, Vector3d::Constant(0.03), 3e-3}}) {
    const SceneImage image = one_object(test.shape);
    Random random(22);
    double worst = 0;
    double most_J = 0;
    int crossings = 0;
    constexpr int kLoops = kUnderSanitizers ? 4 : 12;
    for (int loop = 0; loop < kLoops; ++loop) {
      // A smooth closed curve: two harmonics in each coordinate.
      const Vector3d c = random.in_box(0.3 * test.half_m), a = random.in_box(test.half_m),
                     b = random.in_box(test.half_m), d = random.in_box(0.4 * test.half_m);
      IdealRun run(image);
      double stored_J = 0;
      bool felt = false;
      run.restart(c + b);
      constexpr int kSteps = 10000;
      for (int i = 1; i <= kSteps; ++i) {
        const double t = 2.0 * std::numbers::pi * i / kSteps;
        run.step(c + a * std::sin(t) + b * std::cos(t) + d * std::sin(2.0 * t));
        stored_J = std::max(stored_J, std::abs(run.work_mean_force_J()));
        crossings += felt != (run.felt().contacts > 0) ? 1 : 0;
        felt = run.felt().contacts > 0;
      }
      most_J = std::max(most_J, stored_J);
      if (stored_J > 1e-6) worst = std::max(worst, std::abs(run.work_mean_force_J()) / stored_J);
    }
    figure(test.name + ": times through the surface", crossings, "many");
    figure(test.name + ": most energy stored, J", most_J, "");
    EXPECT_GT(crossings, kLoops / 2);
    EXPECT_LT(figure(test.name + ": work of a closed path, of the energy stored", worst,
                     std::to_string(test.limit)),
              test.limit);
  }
}

TEST(PotentialField, AHardInclusionIsFelt) {
  const SceneImage image = one_object(kLump, "\"stiffness_N_m\": 200");
  const auto press = [&](double x) {
    IdealRun run(image);
    run.step({x, 0, 0.021});
    run.move({x, 0, 0.018}, 1.0e-4);
    return run.felt().force_N.z() / 0.002;
  };
  const double above = press(0.01);
  const double beside = press(-0.02);
  figure("2 mm deep above the lump, N/m", above, "");
  figure("2 mm deep beside it, N/m", beside, "");
  EXPECT_GT(figure("above the lump against beside it", above / beside, "at least 2"), 2.0);

  // A place with more source is harder too.
  const SceneImage region =
      one_object(R"("potential_field": {"shape": {"box": {"size_m": [0.08, 0.06, 0.04]}}, "step_m": 0.002,
    "source_per_m": 50, "regions": [{"shape": {"cylinder": {"radius_m": 0.008, "height_m": 0.03}},
    "pose": {"position_m": [0.01, 0, 0]}, "source_per_m": 150}]})",
                 "\"stiffness_N_m\": 200");
  const auto at = [&](double x) {
    IdealRun run(region);
    run.step({x, 0, 0.021});
    return run.move({x, 0, 0.018}, 1.0e-4).force_N.z();
  };
  EXPECT_GT(figure("above the region of more source against beside it", at(0.01) / at(-0.02), "at least 1.5"),
            1.5);
}

TEST(PotentialField, TheForceHasNoSteps) {
  // Through the whole of it, cells and surface, in steps of 10 um: no step beyond the stiffest place's.
  constexpr double kStep_m = 1.0e-5;
  const SceneImage image = one_object(kLump, "\"stiffness_N_m\": 200");
  IdealRun run(image);
  ForceStep step;
  run.step({-0.05, -0.035, 0.025});
  Random random(23);
  for (int i = 0; i < 40; ++i) add_largest_step(run, random.in_box({0.05, 0.035, 0.025}), kStep_m, step);
  figure("lump: largest force step per 10 um, N", step.most_N, "");
  // Halving the way halves the step: a jump would stay.
  IdealRun finer(image);
  ForceStep half;
  finer.step({-0.05, -0.035, 0.025});
  Random again(23);
  for (int i = 0; i < 40; ++i)
    add_largest_step(finer, again.in_box({0.05, 0.035, 0.025}), 0.5 * kStep_m, half);
  EXPECT_LT(figure("lump: the same over 5 um, of that", half.most_N / step.most_N, "0.5, at most 0.55"),
            0.55);
  // The law of energy begins with a step, as its documentation says.
  IdealRun sharp(one_object(kSpheresOfEnergy));
  ForceStep entry;
  sharp.step({0, 0, 0.041});
  add_largest_step(sharp, {0, 0, 0.038}, kStep_m, entry);
  const double closed = between_spheres(kOuter_m).slope;
  EXPECT_NEAR(
      figure("energy: the step at the surface, N", entry.most_N, "closed form " + std::to_string(closed)),
      closed, 0.01 * closed);
}

TEST(PotentialField, DampingNeverPullsAndCostsTheHand) {
  const SceneImage image = one_object(kSpheres, R"("stiffness_N_m": 500, "damping_N_s_m": 3)");
  IdealRun run(image);
  run.restart({0.002, 0.001, 0.041});
  double least_N = 0;
  for (int i = 1; i <= 8000; ++i) {
    const Felt& felt =
        run.step({0.002, 0.001, 0.041 - 0.003 * (1.0 - std::cos(2.0 * std::numbers::pi * i / 2000.0))});
    least_N = std::min(least_N, felt.force_N.dot(felt.tip_m));
  }
  EXPECT_GE(figure("damped: least force outwards times radius, N m", least_N, "0"), 0.0);
  EXPECT_LT(figure("damped: work on the hand of four presses, J", run.work_mean_force_J(), "below -1e-4"),
            -1e-4);
}

}  // namespace
}  // namespace thimble::test
