// The control points against the spline by its definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "host-tools/lab/spline.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

// Uniform cubic B-spline, in cells from the first value; the control points begin one cell before it.
double spline_at(const std::vector<double>& control, std::size_t columns, double u, double v) {
  const auto weights = [](double t) {
    const double s = 1 - t;
    return std::array<double, 4>{s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                 (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
  };
  const auto cell = [](double at, double last) { return std::clamp(std::floor(at), 0., last); };
  const std::size_t rows = control.size() / columns;
  const double cu = cell(u, static_cast<double>(columns) - 4), cv = cell(v, static_cast<double>(rows) - 4);
  const auto wu = weights(u - cu), wv = weights(v - cv);
  double value = 0;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i)
      value += wv.at(j) * wu.at(i) *
               control[(static_cast<std::size_t>(cv) + j) * columns + static_cast<std::size_t>(cu) + i];
  return value;
}

double worst(const std::function<double(double, double)>& f, std::size_t columns, std::size_t rows,
             double step) {
  std::vector<double> values;
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < columns; ++i)
      values.push_back(f(static_cast<double>(i), static_cast<double>(j)));
  const auto control = host::spline_control_points(values, columns, rows);
  EXPECT_EQ(control.size(), (columns + 2) * (rows + 2));
  double most = 0;
  for (double v = 0; v <= static_cast<double>(rows - 1) + 1e-9; v += step)
    for (double u = 0; u <= static_cast<double>(columns - 1) + 1e-9; u += step)
      most = std::max(most, std::abs(spline_at(control, columns + 2, u, v) - f(u, v)));
  return most;
}

TEST(SplineControlPoints, PassThroughTheValues) {
  const auto rough = [](double u, double v) { return 300 + 150 * std::sin(7.3 * u) * std::cos(5.1 * v + u); };
  for (const std::size_t columns : {2U, 3U, 4U, 5U, 9U, 33U}) {
    const double off = worst(rough, columns, 7, 1.0);
    EXPECT_LE(off, 1e-9 * 450) << columns;
  }
}

TEST(SplineControlPoints, WhatIsBilinearComesBackEverywhere) {
  const auto bilinear = [](double u, double v) { return 3 + u - 2 * v + .5 * u * v; };
  EXPECT_LE(worst(bilinear, 2, 3, .125), 1e-12);
  EXPECT_LE(worst(bilinear, 9, 6, .125), 1e-11);
}

// Halving the cell divides the error by 2^4, away from the ends; a wave with no curvature there has none of theirs.
TEST(SplineControlPoints, ConvergeWithTheFourthPower) {
  const auto error = [](std::size_t cells) {
    return worst(
        [=](double u, double v) {
          return std::sin(std::numbers::pi * u / static_cast<double>(cells)) * (1 + .1 * v);
        },
        cells + 1, 3, .125);
  };
  const double coarse = error(6), fine = error(12);
  figure("half a sine over 6 cells off its spline", coarse, "<= 1e-3");
  figure("error of 6 cells over that of 12", coarse / fine, "16 +- 3");
  EXPECT_LE(coarse, 1e-3);
  EXPECT_NEAR(coarse / fine, 16, 3);
}

}  // namespace
}  // namespace thimble::test
