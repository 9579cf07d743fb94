// The named bounds of a tick: a motion that is cut short ends where it was proven free, is counted, and
// continues in the next tick.
#include <gtest/gtest.h>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

constexpr int kSheets = 20'000;
constexpr double kGap_m = 2e-5;  // wide enough not to be closed
constexpr double kTop_m = kGap_m * (kSheets - 1);

// Squares in a stack. half: of each, the half with y < x.
host::TriangleSoup stack_of_sheets(bool half) {
  host::TriangleSoup soup;
  for (int i = 0; i < kSheets; ++i) {
    const double z = kGap_m * i;
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.insert(soup.vertices_m.end(),
                           {{-0.01, -0.01, z}, {0.01, -0.01, z}, {0.01, 0.01, z}, {-0.01, 0.01, z}});
    soup.triangles.push_back({first, first + 1, first + 2});
    if (!half) soup.triangles.push_back({first, first + 2, first + 3});
  }
  return soup;
}

// A flight beside all of them, through their boxes: more than a sweep may visit.
TEST(Bounds, ASweepCutShortLeavesTheGodObjectWhereItWas) {
  const SceneImage image = SceneBuilder().mesh(stack_of_sheets(true), {}).image();
  IdealRun run(image);
  const Vector3d above(-0.002, 0.002, kTop_m + 0.001);
  run.step(above);

  run.step({-0.002, 0.002, -0.01});
  figure("flight past 20 000 sheets: sweeps cut short", run.renderer().counters().sweep_bound, "> 0");
  EXPECT_GT(run.renderer().counters().sweep_bound, 0U);
  EXPECT_LT((run.felt().god_object_m - above).norm(), 1e-6);
  EXPECT_EQ(run.felt().contacts, 0);
  EXPECT_EQ(run.felt().force_N.norm(), 0.0);

  // A flight short enough to be known finds the top sheet.
  run.step({0.002, -0.002, kTop_m - 5e-5});
  EXPECT_EQ(run.felt().contacts, 1);
  EXPECT_NEAR(run.felt().god_object_m.z(), kTop_m, 1e-6);
}

TEST(Bounds, AFlightIntoAStackEndsAtTheFirstSheet) {
  const SceneImage image = SceneBuilder().mesh(stack_of_sheets(false), {}).image();
  IdealRun run(image);
  run.step({0.001, 0.002, kTop_m + 0.001});
  run.step({0.001, 0.002, -0.01});
  const control::RenderCounters counters = run.renderer().counters();
  figure("flight into 20 000 sheets: work", counters.most_work, "< 1000");
  EXPECT_LT(counters.most_work, 1000U);
  EXPECT_EQ(counters.sweep_bound, 0U);
  EXPECT_EQ(run.felt().contacts, 1);
  EXPECT_NEAR(run.felt().god_object_m.z(), kTop_m, 1e-6);
}

TEST(Bounds, ASlideCutShortStaysOnTheSurfaceAndGoesOn) {
  const host::TriangleSoup ball = icosphere(7, 0.05);
  const MeshOracle oracle(ball);
  const SceneImage image = SceneBuilder().mesh(ball, {}).image();
  IdealRun run(image);
  run.step({0.0, 0.0, 0.06});
  run.step({0.0, 0.0, 0.045});
  const Vector3d target = 0.045 * Vector3d(1.0, 0.3, -0.8).normalized();
  run.step(target);
  const auto cut_short = run.renderer().counters().slide_bound;
  figure("slide over a third of 327 680 faces: slides cut short", cut_short, "> 0");
  EXPECT_GT(cut_short, 0U);
  int ticks = 1;
  for (; ticks < 50 && run.felt().god_object_m.normalized().dot(target.normalized()) < 0.9999; ++ticks) {
    EXPECT_LT(oracle.nearest(run.felt().god_object_m).distance_m, 1e-6);
    run.step(target);
  }
  figure("ticks until it arrives", ticks, "< 50");
  EXPECT_LT(ticks, 50);
}

}  // namespace
}  // namespace thimble::test
