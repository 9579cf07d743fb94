// Whole scans of curved, layered, tilted specimens with damping and friction, by three simulated arms: what the scan finds against what
// the specimen is, and the forces of the scene that it writes against those of the specimen.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/closed_loop/scan/scanner.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/sanitizers.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

using board::Specimen;
using Eigen::Vector3d;
using host::ScanPlan;

using Heights = std::function<double(double u_m, double v_m)>;

Heights cap(double radius_m) {
  return [=](double u_m, double v_m) {
    return std::sqrt(radius_m * radius_m - u_m * u_m - v_m * v_m) - radius_m;
  };
}
Heights saddle(double radius_m) {
  return [=](double u_m, double v_m) { return (u_m * u_m - v_m * v_m) / (2 * radius_m); };
}
Heights cylinder(double radius_m) {
  return [=](double u_m, double) { return std::sqrt(radius_m * radius_m - u_m * u_m) - radius_m; };
}

struct Made {
  std::string name;
  Heights heights;
  double tilt_deg = 0;  // about an oblique axis
  double stiffness_N_m = 400;
  double damping_N_s_m = 0;
  double static_friction = 0, dynamic_friction = 0;
  std::vector<board::SpecimenLayer> layers = {};
};

constexpr double kTop_m = -.01;

// 90 mm wide, in cells of 1.5 mm, its middle at (0, 0, kTop_m).
std::shared_ptr<const Specimen> made(const Made& of) {
  board::SpecimenMap map;
  const Eigen::AngleAxisd tilt(of.tilt_deg * kDegree, Vector3d(1, 2, 0).normalized());
  map.u = tilt * Vector3d::UnitX();
  map.v = tilt * Vector3d::UnitY();
  map.cell_m = .0015;
  map.columns = map.rows = 61;
  const double half_m = .045;
  map.origin_m = Vector3d(0, 0, kTop_m) - half_m * (map.u + map.v);
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const double u_m = map.cell_m * static_cast<double>(column) - half_m;
      const double v_m = map.cell_m * static_cast<double>(row) - half_m;
      map.stiffness_N_m.push_back(of.stiffness_N_m);
      map.height_m.push_back(of.heights(std::clamp(u_m, -.04, .04), std::clamp(v_m, -.04, .04)));
    }
  }
  map.damping_N_s_m = of.damping_N_s_m;
  map.static_friction = of.static_friction;
  map.dynamic_friction = of.dynamic_friction;
  map.layers = of.layers;
  return std::make_shared<const Specimen>(std::move(map));
}

ScanPlan level_plan(std::size_t sites) {  // knows nothing of the tilt
  ScanPlan plan;
  plan.name = "specimen";
  plan.columns = plan.rows = 3;
  plan.cell_m = .008;
  plan.origin_m = {-.008, -.008, kTop_m};
  plan.u = {1, 0, 0};
  plan.v = {0, 1, 0};
  plan.approach = {0, 0, -1};
  plan.clearance_m = .006;
  plan.depth_m = .012;
  plan.force_limit_N = 2;
  plan.speed_m_s = .012;
  plan.travel_speed_m_s = .05;
  plan.stroke_m = .008;
  plan.most_sites = sites;
  return plan;
}

// The height over the specimen, along its normal.
double above_m(const Specimen& specimen, const Vector3d& point_m) {
  const double up_m = specimen.normal().dot(point_m - specimen.map().origin_m) - specimen.height_m(point_m);
  return up_m * specimen.normal().dot(specimen.normal_at(point_m));
}

struct Errors {
  double shape_m = 0, mean = 0, upper = 0, lower = 0, boundary_m = 0;  // the most, K relative
  double static_friction = 0, dynamic_friction = 0;                    // relative
  double damping_N_s_m = 0, uncertainty_N_s_m = 0;
};

Errors errors_of(const Made& of, const Specimen& specimen, const ScanPlan& plan,
                 const host::ScanResult& result) {
  Errors errors;
  for (double v = 0; v <= static_cast<double>(plan.rows - 1); v += .2) {
    for (double u = 0; u <= static_cast<double>(plan.columns - 1); u += .2)
      errors.shape_m = std::max(errors.shape_m, std::abs(above_m(specimen, result.shape.place_m({u, v}))));
  }
  for (const host::ScannedPoint& point : result.points) {
    errors.mean +=
        (point.fit.stiffness_N_m / of.stiffness_N_m - 1) / static_cast<double>(result.points.size());
    errors.upper = std::max(errors.upper, std::abs(point.fit.stiffness_N_m / of.stiffness_N_m - 1));
    if (of.layers.empty() || !point.fit.layer) continue;
    const double lower_N_m = of.stiffness_N_m * of.layers[0].stiffness_ratio;
    errors.lower = std::max(errors.lower, std::abs(point.fit.layer->below_N_m / lower_N_m - 1));
    errors.boundary_m =
        std::max(errors.boundary_m, std::abs(point.fit.layer->boundary_m - of.layers[0].depth_m));
  }
  EXPECT_EQ(result.layers.has_value(), !of.layers.empty()) << of.name;
  EXPECT_TRUE(result.damping.has_value()) << of.name;
  if (result.damping) {
    errors.damping_N_s_m = result.damping->damping_N_s_m - of.damping_N_s_m;
    errors.uncertainty_N_s_m = result.damping->uncertainty_N_s_m;
  }
  EXPECT_TRUE(result.friction.has_value()) << of.name;
  if (result.friction && of.static_friction > 0) {
    errors.static_friction = result.friction->breakaway.coefficient / of.static_friction - 1;
    errors.dynamic_friction = result.friction->sliding.coefficient / of.dynamic_friction - 1;
  }
  return errors;
}

void report(const std::string& who, const Errors& errors) {
  figure(who + ": shape off, worst, mm", 1e3 * errors.shape_m, "<= 0.2");
  figure(who + ": K off, worst", errors.upper, "<= 0.03");
  if (errors.lower > 0) figure(who + ": K of the lower layer off, worst", errors.lower, "<= 0.03");
  if (errors.lower > 0) figure(who + ": boundary off, worst, mm", 1e3 * errors.boundary_m, "<= 0.1");
  figure(who + ": B off, N s/m", errors.damping_N_s_m, "|.| <= 2 times its uncertainty");
  figure(who + ": B off, over its uncertainty", errors.damping_N_s_m / errors.uncertainty_N_s_m, "|.| <= 2");
  figure(who + ": static friction off", errors.static_friction, "|.| <= 0.1");
  figure(who + ": dynamic friction off", errors.dynamic_friction, "|.| <= 0.1");
  EXPECT_LE(errors.shape_m, 2e-4) << who;
  figure(who + ": K off, mean of the points", errors.mean, "|.| <= 0.03");
  EXPECT_LE(errors.upper, .03) << who;
  EXPECT_LE(std::abs(errors.mean), .03) << who;
  EXPECT_LE(errors.lower, .03) << who;
  EXPECT_LE(errors.boundary_m, 1e-4) << who;
  EXPECT_LE(std::abs(errors.damping_N_s_m), 2 * errors.uncertainty_N_s_m) << who;
  EXPECT_LE(std::abs(errors.static_friction), .1) << who;
  EXPECT_LE(std::abs(errors.dynamic_friction), .1) << who;
}

// The scene, rendered, against the specimen: a tip is led into both, along the same path, with the specimen's own friction.
struct Likeness {
  double rms = 0, most = 0;  // of the difference of the forces, over the RMS of the specimen's force
  double rms_N = 0;
  int ticks = 0;
};
Likeness likeness(const Scanned& scanned, const ScanPlan& plan, const Specimen& specimen, int paths) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "heights.csv") << scanned.heights;
  const auto compiled = host::compile_scene_text(scanned.scene, "scanned.scene.json", folder.path());
  IdealRun run{SceneImage(compiled.image)};
  std::mt19937_64 random(7);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  double off2 = 0, force2 = 0;
  Likeness likeness;
  for (int path = 0; path < paths; ++path) {
    const auto place = [&]() -> Eigen::Vector2d {
      return {within(.3, static_cast<double>(plan.columns) - 1.3),
              within(.3, static_cast<double>(plan.rows) - 1.3)};
    };
    const Eigen::Vector2d from = place(), to = place();
    const Vector3d n = scanned.result.shape.normal(from);
    const Vector3d begin_m = scanned.result.shape.place_m(from);
    const double depth_m = within(.0008, .0025);
    const std::vector<Vector3d> corners = {
        begin_m + .001 * n, begin_m - depth_m * n,
        scanned.result.shape.place_m(to) - depth_m * scanned.result.shape.normal(to),
        begin_m - .5 * depth_m * n, begin_m + .001 * n};
    board::SpecimenGrip grip;
    run.restart(corners[0]);
    Vector3d tip_m = corners[0];
    for (std::size_t leg = 1; leg < corners.size(); ++leg) {
      constexpr double kStep_m = 1e-5;  // 0.04 m/s
      const auto steps = static_cast<int>(std::ceil((corners[leg] - tip_m).norm() / kStep_m));
      const Vector3d start_m = tip_m;
      for (int step = 1; step <= steps; ++step) {
        const Vector3d next_m = start_m + (corners[leg] - start_m) * step / steps;
        const Vector3d velocity_m_s = (next_m - tip_m) * kRate_Hz;
        tip_m = next_m;
        specimen.update(tip_m, velocity_m_s, grip);
        const Vector3d wanted_N = specimen.force_N(tip_m, velocity_m_s, grip);
        const Vector3d off_N = run.step(tip_m).force_N - wanted_N;
        off2 += off_N.squaredNorm();
        force2 += wanted_N.squaredNorm();
        likeness.most = std::max(likeness.most, off_N.norm());
        ++likeness.ticks;
      }
    }
  }
  likeness.rms = std::sqrt(off2 / force2);
  likeness.rms_N = std::sqrt(off2 / likeness.ticks);
  likeness.most /= std::sqrt(force2 / likeness.ticks);
  return likeness;
}

// Scans it, and prints and expects all errors.
void expect_like(const Made& of, const std::string& arm, std::size_t sites = 1) {
  const auto specimen = made(of);
  ScanPlan plan = level_plan(sites);
  if (arm == "wooden" && !of.layers.empty()) plan.speed_m_s = .004;  // heavy: it swings long after the touch
  const Scanned scanned = scan(plan, specimen, arm);
  const std::string who = of.name + ", " + arm;
  report(who, errors_of(of, *specimen, plan, scanned.result));
  figure(who + ": shape at the sites, mm", 1e3 * scanned.result.check_most_m, "reported");
  const Likeness like = likeness(scanned, plan, *specimen, 12);
  figure(who + ": forces of the scene off, RMS part", like.rms, of.layers.empty() ? "<= 0.12" : "reported");
  if (of.layers.empty()) {
    EXPECT_LE(like.rms, .12) << who;
  } else {  // one stiffness for two layers: as the scan says
    figure(who + ": the same, N", like.rms_N,
           "<= what the scan states, " + std::to_string(scanned.result.off_N));
    EXPECT_LE(like.rms_N, scanned.result.off_N) << who;
  }
  figure(who + ": the worst, over the RMS force", like.most, "reported");
}

const std::vector<std::string> kArms = {"premium-1.5", "premium-1.5-frictionless", "wooden"};

TEST(SpecimenScan, FindsShapeStiffnessDampingAndFriction) {
  expect_like({"tilted layered cap", cap(.06), 20, 300, 2, .5, .35, {{.0015, 2.5}}}, kArms[0]);
  if (kUnderSanitizers) return;
  expect_like({"tilted saddle", saddle(.06), 20, 400, 3, .3, .3, {}}, kArms[1]);
  expect_like({"tilted cap", cap(.06), 20, 400, 1, .6, .4, {}}, kArms[2]);
}

// Shape, tilt, stiffness, layers, damping, friction and arm at random. THIMBLE_SCAN_SPECIMENS: how many; 1 if it is not set.
TEST(SpecimenScan, RandomSpecimens) {
  const char* wanted = std::getenv("THIMBLE_SCAN_SPECIMENS");
  const int specimens = wanted == nullptr ? 1 : std::atoi(wanted);
  const char* seed = std::getenv("THIMBLE_SCAN_SEED");
  std::mt19937_64 random(seed == nullptr ? 3 : std::strtoull(seed, nullptr, 10));
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  for (int i = 0; i < specimens; ++i) {
    const double radius_m = within(.06, .15);
    const std::vector<Heights> shapes = {cap(radius_m), saddle(radius_m), cylinder(radius_m)};
    Made of{"specimen " + std::to_string(i), shapes[random() % shapes.size()]};
    of.tilt_deg = within(-20, 20);
    of.stiffness_N_m = within(250, 600);
    of.damping_N_s_m = within(0, 4);
    of.static_friction = within(.25, .8);
    of.dynamic_friction = of.static_friction * (random() % 4 == 0 ? 1 : within(.6, 1));
    if (random() % 2 == 0) {
      of.stiffness_N_m = within(250, 350);
      of.layers = {{within(.0012, .002), within(2, 3)}};
    }
    expect_like(of, kArms[random() % kArms.size()], 2);
  }
}

}  // namespace
}  // namespace thimble::test
