// The fit against moves whose stiffness is known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "host-tools/lab/stiffness_fit.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using host::fit_stiffness;
using host::ProbeSample;
using host::StiffnessFit;

// A way in and back with joint friction, noise, and a surface at contact_m.
std::vector<ProbeSample> ideal(double stiffness_N_m, double contact_m, double friction_N, double offset_N,
                               double noise_N, double peak_N = 1.5) {
  Random random(7);
  std::vector<ProbeSample> samples;
  const double deepest_m = contact_m + peak_N / stiffness_N_m;
  constexpr int kCount = 90;
  for (const bool pressing : {true, false}) {
    for (int i = 0; i <= kCount; ++i) {
      const double part = static_cast<double>(pressing ? i : kCount - i) / kCount;
      const double along_m = contact_m - .004 + part * (deepest_m - contact_m + .004);
      const double force_N = stiffness_N_m * std::max(0., along_m - contact_m) + offset_N +
                             (pressing ? friction_N : -friction_N) + noise_N * random.uniform(-1, 1);
      samples.push_back({pressing, along_m, force_N});
    }
  }
  return samples;
}

TEST(StiffnessFit, IsExactWithoutNoise) {
  for (const double stiffness : {50., 300., 2000.}) {
    for (const double friction : {0., .1}) {
      const auto fit = fit_stiffness(ideal(stiffness, .012, friction, .03, 0));
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->stiffness_N_m, stiffness, 1e-6 * stiffness);
      EXPECT_NEAR(fit->contact_m, .012, 1e-8);
      EXPECT_NEAR(fit->hysteresis_N, friction, 1e-6);
      EXPECT_NEAR(fit->residual_N, 0, 1e-6);
    }
  }
}

TEST(StiffnessFit, ReportsTheNoise) {
  const auto fit = fit_stiffness(ideal(400, 0, .05, 0, .05));
  ASSERT_TRUE(fit);
  figure("stiffness of 400 N/m with +- 0.05 N of noise, N/m", fit->stiffness_N_m, "400 +- 8");
  figure("residual, N (uniform noise: 0.05 / sqrt 3)", fit->residual_N, "0.0289 +- 0.005");
  figure("contact, um", 1e6 * fit->contact_m, "0 +- 40");
  EXPECT_NEAR(fit->stiffness_N_m, 400, 8);
  EXPECT_NEAR(fit->residual_N, .05 / std::sqrt(3.), .005);
  EXPECT_NEAR(fit->contact_m, 0, 4e-5);
}

// Two layers, and damping of the contact: the speed of the tip follows from the samples.
TEST(StiffnessFit, FindsLayersAndTheSpeed) {
  auto samples = ideal(300, .012, 0, .03, .01, 2.0);
  constexpr double kBoundary_m = .0025, kMore_N_m = 400;
  for (ProbeSample& sample : samples) {
    const double depth_m = sample.along_m - .012;
    sample.force_N += kMore_N_m * std::max(depth_m - kBoundary_m, 0.);
    if (depth_m > 0) sample.force_N += sample.pressing ? .05 : -.05;
  }
  const auto fit = fit_stiffness(samples, .02);
  ASSERT_TRUE(fit);
  ASSERT_TRUE(fit->layer);
  figure("upper layer of 300 N/m, N/m", fit->stiffness_N_m, "300 +- 6");
  figure("lower layer of 700 N/m, N/m", fit->layer->below_N_m, "700 +- 14");
  figure("boundary at 2.5 mm, mm", 1e3 * fit->layer->boundary_m, "2.5 +- 0.1");
  figure("contact off, um", 1e6 * (fit->contact_m - .012), "0 +- 40");
  figure("force between the ways, N", fit->hysteresis_N, "0.05 +- 0.005");
  EXPECT_NEAR(fit->stiffness_N_m, 300, 6);
  EXPECT_NEAR(fit->layer->below_N_m, 700, 14);
  EXPECT_NEAR(fit->layer->boundary_m, kBoundary_m, 1e-4);
  EXPECT_NEAR(fit->contact_m, .012, 4e-5);
  EXPECT_NEAR(fit->hysteresis_N, .05, .005);
  EXPECT_NEAR(fit->free_hysteresis_N, 0, .005);
  EXPECT_NEAR(fit->tip_speed_m_s, .02, .001) << "this path is even";
  EXPECT_NEAR(fit->force_N(.004), 300 * .004 + 400 * .0015, .03);
  EXPECT_LT(fit->single(.004).stiffness_N_m, 700);
  EXPECT_GT(fit->single(.004).off_N, .05);
  // With the layers given, the same.
  auto known = *fit;
  host::refit_layers(samples, {700. / 300, kBoundary_m}, .02, known);
  EXPECT_NEAR(known.stiffness_N_m, 300, 4);
  EXPECT_NEAR(known.contact_m, .012, 2e-5);
}

TEST(StiffnessFit, FindsNoContactWhereThereIsNone) {
  EXPECT_FALSE(fit_stiffness({}));
  std::vector<ProbeSample> air;
  air.reserve(50);
  for (int i = 0; i < 50; ++i) air.push_back({i < 25, .001 * i, .05});
  EXPECT_FALSE(fit_stiffness(air)) << "friction alone";
  std::vector<ProbeSample> stuck;
  stuck.reserve(50);
  for (int i = 0; i < 50; ++i) stuck.push_back({i < 25, .01, 1.0});
  EXPECT_FALSE(fit_stiffness(stuck)) << "force without a way";
  auto lost = ideal(400, 0, .05, 0, 0);
  std::erase_if(lost, [](const ProbeSample& s) { return !s.pressing; });
  EXPECT_FALSE(fit_stiffness(lost)) << "no way back";
}

}  // namespace
}  // namespace thimble::test
