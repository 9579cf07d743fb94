#include "host-tools/lab/scan_shape.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "host-tools/lab/spline.h"

namespace thimble::host {
namespace {

constexpr int kRounds = 40;
constexpr double kClose_m = 1e-7;

}  // namespace

ScannedShape::ScannedShape(const ScanPlan& plan, std::span<const Eigen::Vector3d> contacts_m)
    : plan_(plan), up_(plan.normal()) {
  const auto points = static_cast<Eigen::Index>(contacts_m.size());
  Eigen::MatrixXd A(points, static_cast<Eigen::Index>(kTerms));
  Eigen::VectorXd heights(points);
  for (Eigen::Index i = 0; i < points; ++i) {
    const Eigen::Vector3d& contact_m = contacts_m[static_cast<std::size_t>(i)];
    const std::array<double, kTerms> row = terms(below(contact_m));
    for (std::size_t term = 0; term < kTerms; ++term) A(i, static_cast<Eigen::Index>(term)) = row.at(term);
    heights[i] = (contact_m - plan.origin_m).dot(up_);
  }
  // Two points along a side have no curvature.
  if (plan.columns < 3) A.col(4).setZero();
  if (plan.rows < 3) A.col(5).setZero();
  const Eigen::VectorXd best = A.completeOrthogonalDecomposition().solve(heights);
  std::copy_n(best.data(), kTerms, polynomial_.begin());

  // The spline passes through values on the grid, and the contacts are beside it: correct the values until it meets the contacts.
  std::vector<double> values(contacts_m.size(), 0.0);
  for (int round = 0; round < kRounds; ++round) {
    control_ = spline_control_points(values, plan.columns, plan.rows);
    residual_m_ = 0;
    for (std::size_t i = 0; i < contacts_m.size(); ++i) {
      const double off_m = above_m(contacts_m[i]);
      residual_m_ = std::max(residual_m_, std::abs(off_m));
      values[plan.row_of(i) * plan.columns + plan.column_of(i)] += off_m;
    }
    if (residual_m_ < kClose_m) break;
  }
}

std::array<double, ScannedShape::kTerms> ScannedShape::terms(const Eigen::Vector2d& at) const {
  const double u = at.x() - static_cast<double>(plan_.columns - 1) / 2;
  const double v = at.y() - static_cast<double>(plan_.rows - 1) / 2;
  return {1, u, v, u * v, u * u, v * v};
}

ScannedShape::Sample ScannedShape::sample(const Eigen::Vector2d& at) const {
  const double u = at.x() - static_cast<double>(plan_.columns - 1) / 2;
  const double v = at.y() - static_cast<double>(plan_.rows - 1) / 2;
  const auto& c = polynomial_;
  Sample sample;
  const std::array<double, kTerms> row = terms(at);
  for (std::size_t term = 0; term < kTerms; ++term) sample.value_m += c.at(term) * row.at(term);
  sample.slope = {c[1] + c[3] * v + 2 * c[4] * u, c[2] + c[3] * u + 2 * c[5] * v};
  const SplinePlace rest = spline_at(control_, plan_.columns, plan_.rows, at.x(), at.y());
  sample.value_m += rest.value;
  sample.slope += Eigen::Vector2d(rest.du, rest.dv);
  sample.slope /= plan_.cell_m;
  return sample;
}

double ScannedShape::height_m(const Eigen::Vector2d& at) const { return sample(at).value_m; }

Eigen::Vector3d ScannedShape::place_m(const Eigen::Vector2d& at) const {
  return plan_.origin_m + plan_.cell_m * (at.x() * plan_.u + at.y() * plan_.v) + height_m(at) * up_;
}

Eigen::Vector3d ScannedShape::normal(const Eigen::Vector2d& at) const {
  const Eigen::Vector2d slope = sample(at).slope;
  return (up_ - slope.x() * plan_.u - slope.y() * plan_.v).normalized();
}

Eigen::Vector2d ScannedShape::below(const Eigen::Vector3d& point_m) const {
  const Eigen::Vector3d from_m = (point_m - plan_.origin_m) / plan_.cell_m;
  return {from_m.dot(plan_.u), from_m.dot(plan_.v)};
}

double ScannedShape::above_m(const Eigen::Vector3d& point_m) const {
  return (point_m - plan_.origin_m).dot(up_) - height_m(below(point_m));
}

double ScannedShape::depth_m(const Eigen::Vector3d& point_m) const {
  return -above_m(point_m) * normal(below(point_m)).dot(up_);
}

}  // namespace thimble::host
