#include "host-tools/lab/spline.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace thimble::host {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Rows 0 to n - 1: the spline at the values. The last two: no curvature at its ends.
MatrixXd interpolation(Index n) {
  MatrixXd A = MatrixXd::Zero(n + 2, n + 2);
  for (Index i = 0; i < n; ++i) A.row(i).segment(i, 3) << 1.0 / 6, 4.0 / 6, 1.0 / 6;
  A.row(n).head(3) << 1, -2, 1;
  A.row(n + 1).tail(3) << 1, -2, 1;
  return A;
}

MatrixXd solved(const MatrixXd& values) {  // along the columns of the matrix
  MatrixXd right = MatrixXd::Zero(values.rows() + 2, values.cols());
  right.topRows(values.rows()) = values;
  return interpolation(values.rows()).partialPivLu().solve(right);
}

// The four control points about a place between the values, their weights and the slopes of the weights.
struct Window {
  std::size_t first;
  std::array<double, 4> weight, slope;
  double beyond;  // of the place over the end of the values
};
Window window_at(double place, std::size_t values) {
  const double inner = std::clamp(place, 0.0, static_cast<double>(values - 1));
  const double cell = std::min(std::floor(inner), static_cast<double>(values - 2));
  const double t = inner - cell, s = 1 - t;
  return {static_cast<std::size_t>(cell),
          {s * s * s / 6, (4 - 3 * t * t * (1 + s)) / 6, (4 - 3 * s * s * (1 + t)) / 6, t * t * t / 6},
          {-s * s / 2, t * (3 * t - 4) / 2, -s * (3 * s - 4) / 2, t * t / 2},
          place - inner};
}

}  // namespace

std::vector<double> spline_control_points(std::span<const double> values, std::size_t columns,
                                          std::size_t rows) {
  const Eigen::Map<const MatrixXd> given(values.data(), static_cast<Index>(columns),
                                         static_cast<Index>(rows));
  const MatrixXd along_u = solved(given);
  const MatrixXd control = solved(along_u.transpose()).transpose();
  return {control.data(), control.data() + control.size()};
}

SplinePlace spline_at(std::span<const double> control, std::size_t columns, std::size_t rows, double u,
                      double v) {
  const Window along_u = window_at(u, columns), along_v = window_at(v, rows);
  SplinePlace place;
  for (std::size_t j = 0; j < 4; ++j) {
    double value = 0, slope = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double at = control[(along_v.first + j) * (columns + 2) + along_u.first + i];
      value += along_u.weight.at(i) * at;
      slope += along_u.slope.at(i) * at;
    }
    place.value += along_v.weight.at(j) * value;
    place.du += along_v.weight.at(j) * slope;
    place.dv += along_v.slope.at(j) * value;
  }
  place.value += along_u.beyond * place.du + along_v.beyond * place.dv;
  return place;
}

}  // namespace thimble::host
