#include "host-tools/lab/spline.h"

#include <Eigen/LU>

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

}  // namespace

std::vector<double> spline_control_points(std::span<const double> values, std::size_t columns,
                                          std::size_t rows) {
  const Eigen::Map<const MatrixXd> given(values.data(), static_cast<Index>(columns),
                                         static_cast<Index>(rows));
  const MatrixXd along_u = solved(given);
  const MatrixXd control = solved(along_u.transpose()).transpose();
  return {control.data(), control.data() + control.size()};
}

}  // namespace thimble::host
