#include "board/sim/specimen.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace thimble::board {
namespace {

constexpr double kMaxStiffness_N_m = 1e5, kMaxHeight_m = 1.0, kMaxDamping_N_s_m = 1e3, kSquare = 1e-6;
constexpr double kMaxFriction = 10, kMaxRatio = 1000;
constexpr std::size_t kMaxPoints = 1U << 20U, kMaxLayers = 16;
constexpr int kFootSteps = 5;          // the error falls by depth x curvature in each
constexpr double kStopped_m_s = 5e-4;  // of a sliding tip, along the surface: it sticks again

// Catmull-Rom: weights of the four values about a place, and the slopes of the weights.
struct Weights {
  std::array<double, 4> value, slope;
};
Weights catmull_rom(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {
      {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2, (t3 - t2) / 2},
      {(-3 * t2 + 4 * t - 1) / 2, (9 * t2 - 10 * t) / 2, (-9 * t2 + 8 * t + 1) / 2, (3 * t2 - 2 * t) / 2}};
}

// The index of a neighbour, held at the border.
std::size_t held(std::size_t index, std::size_t step, std::size_t count) {
  const std::size_t at = index + step;  // of the neighbour at step - 1
  return at == 0 ? 0 : std::min(at - 1, count - 1);
}

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
  demand(map_.dynamic_friction >= 0 && map_.dynamic_friction <= map_.static_friction &&
             map_.static_friction <= kMaxFriction,
         "the friction is not 0 <= dynamic_friction <= static_friction <= 10");
  demand(map_.layers.size() <= kMaxLayers, "a specimen has at most 16 layers");
  double last_m = 0;
  for (const SpecimenLayer& layer : map_.layers) {
    demand(layer.depth_m > last_m && layer.depth_m <= kMaxHeight_m,
           "the layers are not in order of their depths, above 0 and at most 1 m");
    demand(layer.stiffness_ratio >= 0 && layer.stiffness_ratio <= kMaxRatio,
           "a layer's stiffness_ratio is not within 0 to 1000");
    last_m = layer.depth_m;
  }
  for (const double stiffness : map_.stiffness_N_m)
    demand(stiffness >= 0 && stiffness <= kMaxStiffness_N_m, "a stiffness is not within 0 to 100000 N/m");
  for (const double height : map_.height_m)
    demand(std::abs(height) <= kMaxHeight_m, "a height is not within -1 to 1 m");
  normal_ = map_.u.cross(map_.v).normalized();
  // The cubic between the points goes beyond them by at most a quarter of their range.
  if (!map_.height_m.empty()) {
    const auto [least, most] = std::ranges::minmax_element(map_.height_m);
    highest_m_ = *most + (*most - *least) / 4;
  }
}

Specimen::Cell Specimen::cell_at(const Eigen::Vector3d& point_m) const noexcept {
  const Eigen::Vector3d from_origin_m = point_m - map_.origin_m;
  const auto along = [this, &from_origin_m](const Eigen::Vector3d& axis, std::size_t count, double& part,
                                            bool& inside) {
    const double last = static_cast<double>(count - 1);
    const double place = from_origin_m.dot(axis) / map_.cell_m;
    const double inner = std::clamp(place, 0.0, last);
    inside = inner == place;
    const double whole = std::min(std::floor(inner), last - 1);
    part = inner - whole;
    return static_cast<std::size_t>(whole);
  };
  Cell cell{};
  cell.column = along(map_.u, map_.columns, cell.fu, cell.inside_u);
  cell.row = along(map_.v, map_.rows, cell.fv, cell.inside_v);
  return cell;
}

Specimen::Height Specimen::height_at(const Eigen::Vector3d& point_m) const noexcept {
  if (map_.height_m.empty()) return {};
  const Cell cell = cell_at(point_m);
  const Weights u = catmull_rom(cell.fu), v = catmull_rom(cell.fv);
  Height height{};
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row = &map_.height_m[held(cell.row, j, map_.rows) * map_.columns];
    double value = 0, slope = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double at = row[held(cell.column, i, map_.columns)];
      value += u.value.at(i) * at;
      slope += u.slope.at(i) * at;
    }
    height.value_m += v.value.at(j) * value;
    height.du += v.value.at(j) * slope / map_.cell_m;
    height.dv += v.slope.at(j) * value / map_.cell_m;
  }
  if (!cell.inside_u) height.du = 0;
  if (!cell.inside_v) height.dv = 0;
  return height;
}

double Specimen::stiffness_N_m(const Eigen::Vector3d& point_m) const noexcept {
  const Cell cell = cell_at(point_m);
  const double* low = &map_.stiffness_N_m[cell.row * map_.columns + cell.column];
  const double* high = low + map_.columns;
  return (1 - cell.fv) * ((1 - cell.fu) * low[0] + cell.fu * low[1]) +
         cell.fv * ((1 - cell.fu) * high[0] + cell.fu * high[1]);
}

double Specimen::height_m(const Eigen::Vector3d& point_m) const noexcept {
  return height_at(point_m).value_m;
}

Eigen::Vector3d Specimen::normal_at(const Eigen::Vector3d& point_m) const noexcept {
  const Height height = height_at(point_m);
  return (normal_ - height.du * map_.u - height.dv * map_.v).normalized();
}

double Specimen::layered_depth_m(double depth_m) const noexcept {
  double sum_m = 0, top_m = 0, ratio = 1;
  for (const SpecimenLayer& layer : map_.layers) {
    if (depth_m <= layer.depth_m) break;
    sum_m += ratio * (layer.depth_m - top_m);
    top_m = layer.depth_m;
    ratio = layer.stiffness_ratio;
  }
  return sum_m + ratio * (depth_m - top_m);
}

// The nearest point: the tip, projected onto the tangent plane at the last estimate, gives the next one.
Specimen::Contact Specimen::contact_at(const Eigen::Vector3d& tip_m) const noexcept {
  const double above_m = normal_.dot(tip_m - map_.origin_m);
  if (map_.height_m.empty()) return {tip_m - above_m * normal_, normal_, -above_m};
  if (above_m > highest_m_) return {tip_m, normal_, 0};
  Height height = height_at(tip_m);
  Contact contact{tip_m + (height.value_m - above_m) * normal_, normal_, height.value_m - above_m};
  if (contact.depth_m <= 0) return contact;
  for (int step = 0;; ++step) {
    contact.normal = (normal_ - height.du * map_.u - height.dv * map_.v).normalized();
    contact.depth_m = contact.normal.dot(contact.foot_m - tip_m);
    if (step == kFootSteps) return contact;
    const Eigen::Vector3d next_m = tip_m + contact.depth_m * contact.normal;
    height = height_at(next_m);
    contact.foot_m = next_m + (height.value_m - normal_.dot(next_m - map_.origin_m)) * normal_;
  }
}

double Specimen::normal_force_N(const Contact& contact, const Eigen::Vector3d& velocity_m_s) const noexcept {
  return std::max(stiffness_N_m(contact.foot_m) * layered_depth_m(contact.depth_m) -
                      map_.damping_N_s_m * contact.normal.dot(velocity_m_s),
                  0.0);
}

Eigen::Vector3d Specimen::force_N(const Eigen::Vector3d& tip_m, const Eigen::Vector3d& velocity_m_s,
                                  const SpecimenGrip& grip) const noexcept {
  const Contact contact = contact_at(tip_m);
  if (contact.depth_m <= 0) return Eigen::Vector3d::Zero();
  const double force_N = normal_force_N(contact, velocity_m_s);
  if (!grip.touching || !has_friction()) return force_N * contact.normal;
  Eigen::Vector3d pull_m = grip.anchor_m - contact.foot_m;
  pull_m -= contact.normal.dot(pull_m) * contact.normal;
  Eigen::Vector3d along_N = stiffness_N_m(contact.foot_m) * pull_m;
  const double allowed_N = (grip.sliding ? map_.dynamic_friction : map_.static_friction) * force_N;
  const double size_N = along_N.norm();
  if (size_N > allowed_N) along_N *= allowed_N / size_N;
  return force_N * contact.normal + along_N;
}

void Specimen::update(const Eigen::Vector3d& tip_m, const Eigen::Vector3d& velocity_m_s,
                      SpecimenGrip& grip) const noexcept {
  if (!has_friction()) return;
  const Contact contact = contact_at(tip_m);
  if (contact.depth_m <= 0) {
    grip = {};
    return;
  }
  if (!grip.touching) grip = {true, false, contact.foot_m};
  const double force_N = normal_force_N(contact, velocity_m_s);
  const double stiffness = std::max(stiffness_N_m(contact.foot_m), 1e-9);
  Eigen::Vector3d pull_m = grip.anchor_m - contact.foot_m;
  pull_m -= contact.normal.dot(pull_m) * contact.normal;
  const double size_N = stiffness * pull_m.norm();
  // Away from the anchor: the tip goes on sliding.
  const double away_m_s = size_N > 0 ? -velocity_m_s.dot(pull_m.normalized()) : 0;
  if (grip.sliding && away_m_s < kStopped_m_s) grip.sliding = false;
  if (!grip.sliding && size_N > map_.static_friction * force_N) grip.sliding = true;
  if (!grip.sliding) return;
  const double part = size_N > 0 ? map_.dynamic_friction * force_N / size_N : 0;
  grip.anchor_m = contact.foot_m + part * pull_m;
}

}  // namespace thimble::board
