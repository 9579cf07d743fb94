// The scene made by a scan, compiled and rendered, has the stiffness of the specimen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "board/sim/specimen_file.h"
#include "host-tools/compiler/compile.h"
#include "tests/closed_loop/scan/scanner.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using board::Specimen;
using host::ScanPlan;

// Presses the rendered scene along the surface's normal at (u, v), in cells from the plan's first point, and
// compares.
struct Agreement {
  double worst = 0, rms = 0;  // of K, relative
  int places = 0;
};
Agreement felt(const std::string& scene, const ScanPlan& plan, const Specimen& specimen, double step_cells) {
  const auto compiled = host::compile_scene_text(scene, "scanned.scene.json", {});
  IdealRun run{SceneImage(compiled.image)};
  constexpr double kDepth_m = .002;
  Agreement agreement;
  for (double v = 0; v <= static_cast<double>(plan.rows - 1) + 1e-9; v += step_cells) {
    for (double u = 0; u <= static_cast<double>(plan.columns - 1) + 1e-9; u += step_cells) {
      const Eigen::Vector3d surface_m =
          plan.origin_m + plan.cell_m * (u * plan.u + v * plan.v) +
          specimen.height_m(plan.origin_m + plan.cell_m * (u * plan.u + v * plan.v)) * specimen.normal();
      run.restart(surface_m + .002 * specimen.normal());
      run.move(surface_m - kDepth_m * specimen.normal(), 1e-4);
      run.step(surface_m - kDepth_m * specimen.normal());  // at rest: no damping
      const double felt_N_m = run.felt().force_N.dot(specimen.normal()) / kDepth_m;
      const double off = felt_N_m / specimen.stiffness_N_m(surface_m) - 1;
      agreement.worst = std::max(agreement.worst, std::abs(off));
      agreement.rms += off * off;
      ++agreement.places;
    }
  }
  agreement.rms = std::sqrt(agreement.rms / agreement.places);
  return agreement;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

// scenes/scan: the plan and the specimen as they are, scanned anew, felt at the points and between them.
TEST(Scan, TheSceneFeelsLikeTheSpecimen) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes/scan";
  const ScanPlan plan = host::read_scan_plan(folder / "scan.plan.json");
  const auto specimen = std::make_shared<const Specimen>(board::read_specimen(folder / "specimen.json"));
  const Scanned scanned = scan(plan, specimen);
  double residual_N = 0, at_points = 0;
  for (std::size_t i = 0; i < scanned.result.points.size(); ++i) {
    const host::StiffnessFit& fit = scanned.result.points[i].fit;
    residual_N = std::max(residual_N, fit.residual_N);
    const Eigen::Vector3d place_m = plan.place_m(plan.column_of(i), plan.row_of(i));
    at_points = std::max(at_points, std::abs(fit.stiffness_N_m / specimen->stiffness_N_m(place_m) - 1));
  }
  const Agreement agreement = felt(scanned.scene, plan, *specimen, .5);
  figure("points scanned", static_cast<double>(plan.points()), "reported");
  figure("K found off the specimen's at the points, worst", at_points, "<= 0.05");
  figure("worst residual of a fit, N", residual_N, "<= 0.05");
  figure("K felt off the specimen's at " + std::to_string(agreement.places) + " places, worst",
         agreement.worst, "<= 0.05");
  figure("the same, RMS", agreement.rms, "<= 0.02");
  figure("surface found off the specimen's, RMS, mm", 1e3 * scanned.result.off_plane_rms_m, "<= 0.1");
  ASSERT_TRUE(scanned.result.friction.has_value());
  figure("static friction found, of a specimen without", scanned.result.friction->breakaway.coefficient,
         "|.| <= 0.06");
  figure("dynamic friction found", scanned.result.friction->sliding.coefficient, "|.| <= 0.01");
  EXPECT_LE(std::abs(scanned.result.friction->breakaway.coefficient), .06);
  EXPECT_LE(std::abs(scanned.result.friction->sliding.coefficient), .01);
  EXPECT_LE(at_points, .05);
  EXPECT_LE(residual_N, .05);
  EXPECT_LE(agreement.worst, .05);
  EXPECT_LE(agreement.rms, .02);
  EXPECT_LE(scanned.result.off_plane_rms_m, 1e-4);
}

TEST(Scan, TheSceneThatIsCheckedInFeelsLikeTheSpecimen) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes/scan";
  const ScanPlan plan = host::read_scan_plan(folder / "scan.plan.json");
  const Specimen specimen = board::read_specimen(folder / "specimen.json");
  const Agreement checked_in = felt(text_of(folder / "scan.scene.json"), plan, specimen, .5);
  figure("the scene that is checked in, worst", checked_in.worst, "<= 0.05; make_scan.py writes it anew");
  EXPECT_LE(checked_in.worst, .05);
}

}  // namespace
}  // namespace thimble::test
