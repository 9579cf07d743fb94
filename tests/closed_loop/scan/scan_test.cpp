// Whole scans of specimens whose stiffness and height are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "host-tools/error.h"
#include "tests/closed_loop/scan/scanner.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

using board::Specimen;
using host::ScanPlan;

ScanPlan small_plan(double force_limit_N = 1.5) {
  ScanPlan plan;
  plan.name = "pad";
  plan.origin_m = {-.02, -.02, -.01};
  plan.u = {1, 0, 0};
  plan.v = {0, 1, 0};
  plan.approach = {0, 0, -1};
  plan.columns = plan.rows = 4;
  plan.cell_m = .013;
  plan.clearance_m = .003;
  plan.depth_m = .012;
  plan.force_limit_N = force_limit_N;
  plan.speed_m_s = .025;
  plan.travel_speed_m_s = .05;
  plan.measure_friction = false;  // specimen_scan_test.cpp measures it
  return plan;
}

double wave(double x_m, double y_m) {
  return 400 *
         (1 + .3 * std::sin(2 * std::numbers::pi * x_m / .06) * std::cos(2 * std::numbers::pi * y_m / .07));
}

TEST(Scan, FindsStiffnessOnEveryArmWithDampingAndFriction) {
  const ScanPlan plan = small_plan();
  const auto specimen = specimen_of(-.01, wave, 2.0);
  const std::vector<std::string> arms{"premium-1.5", "premium-1.5-frictionless", "wooden"};
  for (const std::string& arm : std::span(arms).first(kUnderSanitizers ? 1 : arms.size())) {
    const Scanned scanned = scan(plan, specimen, arm);
    double worst = 0, height_m = 0, hysteresis_N = 0;
    for (std::size_t i = 0; i < scanned.result.points.size(); ++i) {
      const host::StiffnessFit& fit = scanned.result.points[i].fit;
      const Eigen::Vector3d place_m = plan.place_m(plan.column_of(i), plan.row_of(i));
      worst = std::max(worst, std::abs(fit.stiffness_N_m / specimen->stiffness_N_m(place_m) - 1));
      height_m = std::max(height_m, std::abs(fit.contact_m));
      hysteresis_N = std::max(hysteresis_N, std::abs(fit.hysteresis_N));
    }
    figure(arm + ": K off the truth, worst of 16 points", worst, "<= 0.04");
    figure(arm + ": surface off the truth, worst, mm", 1e3 * height_m, "<= 0.2");
    figure(arm + ": friction that the model missed, worst, N", hysteresis_N, "reported");
    EXPECT_LE(worst, .04);
    EXPECT_LE(height_m, 2e-4);
  }
}

// A slope is found as a plane; what is not a plane is told.
TEST(Scan, FindsTheSlopeAndTellsWhatIsNotFlat) {
  ScanPlan plan = small_plan();
  plan.columns = plan.rows = 3;
  plan.cell_m = .02;
  const double slope = std::tan(8 * kDegree);
  const auto tilted = scan(plan, specimen_of(
                                     -.01, [](double, double) { return 400.; }, 0,
                                     [=](double x_m, double) { return slope * x_m; }));
  const Eigen::Vector3d normal = Eigen::Vector3d(-slope, 0, 1).normalized();
  figure("normal of a slope of 8 degrees, off by, degrees",
         std::acos(std::min(1., tilted.result.normal.dot(normal))) / kDegree, "<= 0.5");
  figure("its points off the plane, mm", 1e3 * tilted.result.off_plane_most_m, "<= 0.2");
  EXPECT_GT(tilted.result.normal.dot(normal), std::cos(.5 * kDegree));
  EXPECT_LE(tilted.result.off_plane_most_m, 2e-4);
  double worst = 0;
  for (const host::ScannedPoint& point : tilted.result.points)
    worst = std::max(worst, std::abs(point.stiffness_N_m / 400 - 1));
  figure("K along the normal off the truth, worst", worst, "<= 0.05");
  EXPECT_LE(worst, .05);

  const auto bump = scan(plan, specimen_of(
                                   -.01, [](double, double) { return 400.; }, 0,
                                   [](double x_m, double y_m) {
                                     return .003 * std::exp(-(x_m * x_m + y_m * y_m) / (2 * .01 * .01));
                                   }));
  figure("a bump of 3 mm, off the plane, mm", 1e3 * bump.result.off_plane_most_m, "> 0.2, which is not flat");
  EXPECT_GT(bump.result.off_plane_most_m, host::kFlat_m);
  EXPECT_NEAR(bump.result.height_m(plan, 4), .003, 3e-4) << "in the middle";
}

TEST(Scan, TellsWhatGoesWrong) {
  const auto name_of = [](const ScanPlan& plan, const std::shared_ptr<const Specimen>& specimen) {
    try {
      (void)scan(plan, specimen);
      return std::string();
    } catch (const host::Error& error) {
      return error.name;
    }
  };
  ScanPlan air = small_plan();
  air.columns = air.rows = 2;
  EXPECT_EQ(name_of(air, specimen_of(-.05, wave)), "no-contact");
  EXPECT_EQ(name_of(air, specimen_of(.0, [](double, double) { return 2000.; })), "in-the-way");
}

// The scan is the same to the byte every time.
TEST(Scan, IsDeterministic) {
  ScanPlan plan = small_plan();
  plan.columns = plan.rows = 2;
  const auto specimen = specimen_of(-.01, wave);
  EXPECT_EQ(scan(plan, specimen).scene, scan(plan, specimen).scene);
}

}  // namespace
}  // namespace thimble::test
