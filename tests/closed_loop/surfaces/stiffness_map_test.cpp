// Non-homogeneous surfaces (paper, section 5.1): a bicubic B-spline of stiffness and damping, 4 x 4 points at a time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "control/surfaces/spline.h"
#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

constexpr int kSide = 9;
constexpr double kCell_m = 0.004;

std::size_t at(int i, int j) { return static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i); }

// 300 N/m with a hard spot of `top` in the middle.
std::vector<float> hard_spot(double top) {
  std::vector<float> points;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double r2 = (i - 4) * (i - 4) + (j - 4) * (j - 4);
      points.push_back(static_cast<float>(300.0 + (top - 300.0) * std::exp(-r2 / 4.0)));
    }
  }
  return points;
}

std::string as_rows(const std::vector<float>& points) {  // the last row of the text is the first of the grid
  std::ostringstream text;
  for (int j = kSide - 1; j >= 0; --j) {
    text << (j == kSide - 1 ? "[[" : ", [");
    for (int i = 0; i < kSide; ++i) text << (i > 0 ? ", " : "") << points[at(i, j)];
    text << "]";
  }
  return text.str() + "]";
}

std::string mapped(bool conservative, double top = 1200.0, const std::string& extra = {}) {
  return "\"stiffness_N_m\": 300" + extra +
         ", \"stiffness_map\": {\"stiffness_N_m\": " + as_rows(hard_spot(top)) +
         ", \"cell_m\": 0.004, \"origin_m\": [-0.016, -0.016, 0], \"conservative\": " +
         (conservative ? "true" : "false") + "}";
}

control::SplineSample look(const std::vector<float>& points, float u, float v) {
  const auto along = control::spline_window(u, kSide, control::Beyond::kClamped);
  const auto across = control::spline_window(v, kSide, control::Beyond::kClamped);
  return control::spline_sample(points.data(), kSide, along, across);
}

// Every point but one is not a number in turn: the result is one just for the 16 about the place.
TEST(StiffnessMap, TouchesTheSixteenPointsAboutThePlaceAndNoOther) {
  const std::vector<float> sound = hard_spot(1200);
  Random random(2);
  int least = 1000;
  int most = 0;
  bool where_expected = true;
  for (int trial = 0; trial < 50; ++trial) {
    const auto u = static_cast<float>(random.uniform(1, kSide - 2));
    const auto v = static_cast<float>(random.uniform(1, kSide - 2));
    int touched = 0;
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        std::vector<float> poisoned = sound;
        poisoned[at(i, j)] = std::numeric_limits<float>::quiet_NaN();
        const control::SplineSample sample = look(poisoned, u, v);
        const bool sees = std::isnan(sample.value);
        touched += sees ? 1 : 0;
        const int di = i - static_cast<int>(std::floor(u));
        const int dj = j - static_cast<int>(std::floor(v));
        where_expected = where_expected && sees == (di >= -1 && di <= 2 && dj >= -1 && dj <= 2);
      }
    }
    least = std::min(least, touched);
    most = std::max(most, touched);
  }
  figure("points touched, least", least, "16");
  figure("points touched, most", most, "16");
  EXPECT_EQ(least, 16);
  EXPECT_EQ(most, 16);
  EXPECT_TRUE(where_expected);
}

// Value, slope and curvature on both sides of a cell's border.
TEST(StiffnessMap, IsC2AcrossCells) {
  const std::vector<float> points = hard_spot(1200);
  constexpr double kStep = 0.02;
  double value_jump = 0;
  double slope_jump = 0;
  double curve_jump = 0;
  double slope_error = 0;
  double curve_most = 0;
  for (int border = 0; border < kSide; ++border) {  // the outermost too, where the map goes on
    for (double v = 0.3; v < kSide - 1; v += 0.37) {
      const auto at = [&](double u) {
        return static_cast<double>(look(points, static_cast<float>(u), static_cast<float>(v)).value);
      };
      const auto slope = [&](double u) {
        return static_cast<double>(look(points, static_cast<float>(u), static_cast<float>(v)).du);
      };
      const double b = border;
      value_jump = std::max(value_jump, std::abs(at(b + 1e-4) - at(b - 1e-4)) - std::abs(slope(b)) * 2e-4);
      slope_error = std::max(
          slope_error, std::abs((at(b + 0.5 + kStep) - at(b + 0.5 - kStep)) / (2 * kStep) - slope(b + 0.5)));
      slope_jump = std::max(slope_jump, std::abs(slope(b + 1e-4) - slope(b - 1e-4)));
      // Inside a cell the slope is a parabola: its derivative at the border from three points on one side.
      const auto curve = [&](double side) {
        return side *
               (-3 * slope(b + side * 1e-3) + 4 * slope(b + side * (1e-3 + kStep)) -
                slope(b + side * (1e-3 + 2 * kStep))) /
               (2 * kStep);
      };
      curve_jump = std::max(curve_jump, std::abs(curve(1) - curve(-1)));
      curve_most = std::max(curve_most, std::abs(curve(1)));
    }
  }
  figure("step of K at a cell's border, N/m", value_jump, "0.01, of 900");
  figure("step of its slope, N/m per cell", slope_jump, "0.2");
  figure("step of its curvature, N/m per cell squared", curve_jump, "5, of " + std::to_string(curve_most));
  figure("slope less the finite difference", slope_error, "0.5");
  EXPECT_LT(value_jump, 0.01);
  EXPECT_LT(slope_jump, 0.2);
  EXPECT_LT(curve_jump, 5.0);
  EXPECT_GT(curve_most, 100.0);
  EXPECT_LT(slope_error, 0.5);
}

TEST(StiffnessMap, IsWhatThePressFeels) {
  const std::vector<float> points = hard_spot(1200);
  std::vector<float> damping(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) damping[i] = points[i] / 200.0F;
  const std::string material =
      "\"stiffness_N_m\": 300, \"stiffness_map\": {\"stiffness_N_m\": " + as_rows(points) +
      ", \"damping_N_s_m\": " + as_rows(damping) +
      ", \"cell_m\": 0.004, \"origin_m\": [-0.016, -0.016, 0], \"conservative\": false}";
  const SceneImage image = surface_scene(material);
  IdealRun run(image);
  double worst = 0;
  double worst_damping = 0;
  for (double x = -0.03; x <= 0.03; x += 0.0017) {
    for (double y = -0.03; y <= 0.03; y += 0.0023) {
      run.restart({x, y, 0.001});
      run.move({x, y, -0.002}, 2.5e-5);
      const double moving_N = run.felt().force_N.z();
      for (int i = 0; i < 3; ++i) run.step({x, y, -0.002});
      const double k = static_cast<double>(
          look(points, static_cast<float>((x + 0.016) / kCell_m), static_cast<float>((y + 0.016) / kCell_m))
              .value);
      worst = std::max(worst, std::abs(run.felt().force_N.z() / 0.002 - k) / k);
      worst_damping =
          std::max(worst_damping, std::abs((moving_N - run.felt().force_N.z()) / 0.1 - k / 200.0));
    }
  }
  figure("stiffness felt less the spline's, relative", worst, "1e-3");
  figure("damping felt less the spline's, N s/m", worst_damping, "0.05");
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(worst_damping, 0.05);
}

// Pressed where it is soft, moved to the hard spot under the surface, let go there: plain interpolation gives (K2 - K1) d^2 / 2.
TEST(StiffnessMap, WorkOfClosedPaths) {
  const std::vector<float> points = hard_spot(1200);
  const double soft = static_cast<double>(look(points, 0.25F, 4.0F).value);
  const double hard = static_cast<double>(look(points, 4.0F, 4.0F).value);
  constexpr double kDepth_m = 0.002;
  const double plain_J = 0.5 * (hard - soft) * kDepth_m * kDepth_m;
  const double stored_J = 0.5 * hard * kDepth_m * kDepth_m;
  for (const bool conservative : {false, true}) {
    const SceneImage image = surface_scene(mapped(conservative));
    for (const bool to_hard : {true, false}) {
      IdealRun run(image);
      const double from = to_hard ? -0.015 : 0.0;
      const double to = to_hard ? 0.0 : -0.015;
      run.restart({from, 0, 0.001});
      run.move({from, 0, -kDepth_m}, 5e-6);
      run.move({to, 0, -kDepth_m}, 5e-6);
      run.move({to, 0, 0.001}, 5e-6);
      run.move({from, 0, 0.001}, 5e-6);
      const double work = run.work_mean_force_J() / stored_J;
      const std::string what = std::string(conservative ? "conservative" : "plain") +
                               (to_hard ? ": soft, then hard" : ": hard, then soft");
      if (conservative) {
        figure(what + ", work on the hand over what the hard spot stores", work, "0 within 1e-3");
        EXPECT_NEAR(work, 0.0, 1e-3);
      } else {
        figure(what + ", work on the hand over what the hard spot stores", work,
               to_hard
                   ? "the formula's " + std::to_string(plain_J / stored_J) + ", taken by the account: < 1e-3"
                   : std::to_string(-plain_J / stored_J) + " within 1 %");
        EXPECT_LT(work, 1e-3);
        if (!to_hard) {
          EXPECT_NEAR(work, -plain_J / stored_J, 0.01);
        }
      }
    }
  }
}

TEST(StiffnessMap, RandomLoopsOverTheConservativeMapDoNoWorkAndOverTheOthersGiveNone) {
  struct Case {
    std::string what;
    std::string material;
    std::string shape;
    bool exact;
  };
  const std::vector<Case> cases{
      {"conservative on a plane", mapped(true), kFloor, true},
      {"plain on a plane", mapped(false), kFloor, false},
      {"conservative with friction", mapped(true, 1200, ", \"static_friction\": 0.4"), kFloor, false},
      {"conservative on a sphere", mapped(true), R"("sphere": {"radius_m": 0.03})", true},
      {"conservative on a box", mapped(true), R"("box": {"size_m": [0.05, 0.05, 0.05]})", false}};
  for (const Case& c : cases) {
    const SceneImage image = surface_scene(c.material, c.shape);
    const double top_m = c.shape == kFloor ? 0.0 : c.what.ends_with("sphere") ? 0.03 : 0.025;
    IdealRun run(image);
    Random random(19);
    double most = -1e9;
    double least = 1e9;
    for (int loop = 0; loop < 40; ++loop) {
      constexpr double kStep_m = 1e-5;
      const auto below = [&](double depth_m) {  // a tip at that depth, somewhere near the hard spot
        Vector3d p = random.in_box({0.012, 0.012, 0});
        const double surface_m =
            c.what.ends_with("sphere") ? std::sqrt(0.03 * 0.03 - p.squaredNorm()) : top_m;
        p.z() = surface_m - depth_m;
        return p;
      };
      const Vector3d free = below(-0.001);
      run.restart(free);
      run.move(free - Vector3d(0, 0, 0.003), kStep_m);
      for (int leg = 0; leg < 5; ++leg) run.move(below(random.uniform(0.0015, 0.003)), kStep_m);
      run.move(free - Vector3d(0, 0, 0.003), kStep_m);
      run.move(free, kStep_m);
      const double stored_J = 0.5 * 1000 * 0.002 * 0.002;
      most = std::max(most, run.work_mean_force_J() / stored_J);
      least = std::min(least, run.work_mean_force_J() / stored_J);
    }
    figure(c.what + ": most work on the hand over a press of 2 mm on the spot", most, "2e-3");
    figure(c.what + ": least", least, c.exact ? "-2e-3" : "reported");
    EXPECT_LT(most, 2e-3);
    if (c.exact) {
      EXPECT_GT(least, -2e-3);
    }
  }
}

}  // namespace
}  // namespace thimble::test
