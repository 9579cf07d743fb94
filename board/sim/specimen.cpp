#include "board/sim/specimen.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace thimble::board {
namespace {

constexpr double kMaxStiffness_N_m = 1e5, kMaxHeight_m = 1.0, kMaxDamping_N_s_m = 1e3, kSquare = 1e-6;
constexpr std::size_t kMaxPoints = 1U << 20U;

void demand(bool condition, const char* sentence) {
  if (!condition) throw std::invalid_argument(sentence);
}

}  // namespace

Specimen::Specimen(SpecimenMap map) : map_(std::move(map)) {
  demand(map_.columns >= 2 && map_.rows >= 2 && map_.columns <= kMaxPoints / map_.rows,
         "a specimen has at least 2 columns and 2 rows, and at most 1048576 points");
  const std::size_t points = map_.columns * map_.rows;
  demand(map_.stiffness_N_m.size() == points, "stiffness_N_m does not have columns x rows numbers");
  demand(map_.height_m.empty() || map_.height_m.size() == points,
         "height_m does not have columns x rows numbers");
  demand(map_.cell_m > 0 && map_.cell_m <= kMaxHeight_m, "cell_m is not above 0 and at most 1");
  demand(map_.origin_m.allFinite(), "origin_m is not finite");
  demand(std::abs(map_.u.norm() - 1) < kSquare && std::abs(map_.v.norm() - 1) < kSquare &&
             std::abs(map_.u.dot(map_.v)) < kSquare,
         "u and v are not perpendicular unit vectors");
  demand(map_.damping_N_s_m >= 0 && map_.damping_N_s_m <= kMaxDamping_N_s_m,
         "damping_N_s_m is not within 0 to 1000");
  for (const double stiffness : map_.stiffness_N_m)
    demand(stiffness >= 0 && stiffness <= kMaxStiffness_N_m, "a stiffness is not within 0 to 100000 N/m");
  for (const double height : map_.height_m)
    demand(std::abs(height) <= kMaxHeight_m, "a height is not within -1 to 1 m");
  normal_ = map_.u.cross(map_.v).normalized();
}

Specimen::Cell Specimen::cell_at(const Eigen::Vector3d& point_m) const noexcept {
  const Eigen::Vector3d from_origin_m = point_m - map_.origin_m;
  const auto along = [this, &from_origin_m](const Eigen::Vector3d& axis, std::size_t count, double& part,
                                            bool& inside) {
    const double last = static_cast<double>(count - 1);
    const double place = from_origin_m.dot(axis) / map_.cell_m;
    const double held = std::clamp(place, 0.0, last);
    inside = held == place;
    const double whole = std::min(std::floor(held), last - 1);
    part = held - whole;
    return static_cast<std::size_t>(whole);
  };
  Cell cell{};
  const std::size_t column = along(map_.u, map_.columns, cell.fu, cell.inside_u);
  const std::size_t row = along(map_.v, map_.rows, cell.fv, cell.inside_v);
  cell.first = row * map_.columns + column;
  return cell;
}

double Specimen::at(const std::vector<double>& values, const Cell& cell) const noexcept {
  const double* low = &values[cell.first];
  const double* high = low + map_.columns;
  return (1 - cell.fv) * ((1 - cell.fu) * low[0] + cell.fu * low[1]) +
         cell.fv * ((1 - cell.fu) * high[0] + cell.fu * high[1]);
}

double Specimen::stiffness_N_m(const Eigen::Vector3d& point_m) const noexcept {
  return at(map_.stiffness_N_m, cell_at(point_m));
}

double Specimen::height_m(const Eigen::Vector3d& point_m) const noexcept {
  return map_.height_m.empty() ? 0.0 : at(map_.height_m, cell_at(point_m));
}

Eigen::Vector3d Specimen::force_N(const Eigen::Vector3d& tip_m,
                                  const Eigen::Vector3d& velocity_m_s) const noexcept {
  const Cell cell = cell_at(tip_m);
  Eigen::Vector3d normal = normal_;
  double depth_m = -normal_.dot(tip_m - map_.origin_m);
  if (!map_.height_m.empty()) {
    depth_m += at(map_.height_m, cell);
    if (depth_m <= 0) return Eigen::Vector3d::Zero();
    const double* low = &map_.height_m[cell.first];
    const double* high = low + map_.columns;
    const double du = (1 - cell.fv) * (low[1] - low[0]) + cell.fv * (high[1] - high[0]);
    const double dv = (1 - cell.fu) * (high[0] - low[0]) + cell.fu * (high[1] - low[1]);
    const Eigen::Vector3d steep = normal_ - (cell.inside_u ? du / map_.cell_m : 0.0) * map_.u -
                                  (cell.inside_v ? dv / map_.cell_m : 0.0) * map_.v;
    depth_m /= steep.norm();  // perpendicular to the slope
    normal = steep.normalized();
  }
  if (depth_m <= 0) return Eigen::Vector3d::Zero();
  const double force_N =
      at(map_.stiffness_N_m, cell) * depth_m - map_.damping_N_s_m * normal.dot(velocity_m_s);
  return std::max(force_N, 0.0) * normal;
}

}  // namespace thimble::board
