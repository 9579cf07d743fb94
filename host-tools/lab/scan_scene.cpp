#include "host-tools/lab/scan_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "control/scene/limits.h"
#include "host-tools/error.h"
#include "host-tools/lab/spline.h"

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPerCell = 16, kMostHeights = 65536;

// Rounded below what a scan resolves.
double tidy(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }

Json vector_json(const Eigen::Vector3d& v, double per_unit) {
  return {tidy(v.x(), per_unit), tidy(v.y(), per_unit), tidy(v.z(), per_unit)};
}

// How many steps of the height field a cell is divided into.
std::size_t steps_per_cell(const ScanPlan& plan, const ScannedShape& shape) {
  // The deviation of a step's middle from the line through its ends is a quarter of that of a step twice as long.
  double bend_m = 0;
  const auto bend = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& half) {
    bend_m = std::max(
        bend_m, std::abs(shape.height_m(at) - (shape.height_m(at - half) + shape.height_m(at + half)) / 2));
  };
  for (double v = 0; v <= static_cast<double>(plan.rows - 1); v += 0.5) {
    for (double u = 0; u <= static_cast<double>(plan.columns - 1); u += 0.5) {
      bend({u, v}, {0.5, 0});
      bend({u, v}, {0, 0.5});
      bend({u, v}, {0.5, 0.5});
      bend({u, v}, {0.5, -0.5});
    }
  }
  auto steps = static_cast<std::size_t>(std::ceil(std::sqrt(bend_m / kGridError_m)));
  steps = std::clamp<std::size_t>(steps, 1, kMostPerCell);
  while (steps > 1 && ((plan.columns - 1) * steps + 1) * ((plan.rows - 1) * steps + 1) > kMostHeights)
    --steps;
  return steps;
}

// Of the axes u, v, u x v: about x, then y, then z, fixed axes.
Eigen::Vector3d rotation_deg(const ScanPlan& plan) {
  const Eigen::Vector3d up = plan.normal();
  constexpr double kDegree = 180 / std::numbers::pi;
  const double pitch = std::atan2(-plan.u.z(), std::hypot(plan.u.x(), plan.u.y()));
  if (std::hypot(plan.u.x(), plan.u.y()) < 1e-9)  // along z: roll and yaw turn about one axis
    return Eigen::Vector3d(std::atan2(-plan.v.x() * plan.u.z(), plan.v.y()), pitch, 0) * kDegree;
  return Eigen::Vector3d(std::atan2(plan.v.z(), up.z()), pitch, std::atan2(plan.u.y(), plan.u.x())) * kDegree;
}

Json stiffness_map(const ScanPlan& plan, const ScanResult& result) {
  const std::vector<double> control =
      spline_control_points(result.stiffness_map(plan), plan.columns, plan.rows);
  const auto [least, most] = std::ranges::minmax(control);
  if (!(least > 0) || most > static_cast<double>(control::kMaxStiffness_N_m)) {
    throw Error(ExitCode::kRefused, "unsmooth-map",
                "the spline through the measured stiffness would need control points from " +
                    std::to_string(least) + " to " + std::to_string(most) + " N/m",
                "scan with a smaller cell_m: the stiffness changes too much from point to point");
  }
  const std::size_t columns = plan.columns + 2;
  Json rows = Json::array();  // the last row is at the least v
  for (std::size_t row = plan.rows + 2; row-- > 0;) {
    Json numbers = Json::array();
    for (std::size_t column = 0; column < columns; ++column)
      numbers.push_back(tidy(control[row * columns + column], 1e2));
    rows.push_back(numbers);
  }
  Json map;
  map["cell_m"] = plan.cell_m;
  if (result.flat) {
    map["origin_m"] = vector_json(plan.place_m(0, 0) - plan.cell_m * (plan.u + plan.v), 1e7);
    map["u"] = vector_json(plan.u, 1e9);
    map["v"] = vector_json(plan.v, 1e9);
  } else {  // in the frame of the height field, from its middle
    map["origin_m"] = vector_json(
        -plan.cell_m / 2 *
            Eigen::Vector3d(static_cast<double>(plan.columns + 1), static_cast<double>(plan.rows + 1), 0),
        1e7);
  }
  map["conservative"] = plan.conservative;
  map["stiffness_N_m"] = rows;
  return map;
}

// One row of numbers a line.
std::string folded(const std::string& text) {
  std::string folded;
  for (std::size_t at = 0, depth = 0; at < text.size(); ++at) {
    if (text[at] == '[') depth += 1;
    if (text[at] == ']') depth -= 1;
    const bool number_list =
        depth > 0 && text[at] == '\n' && text.find_first_of("[{", at) > text.find_first_of("]}", at);
    if (!number_list) {
      folded += text[at];
      continue;
    }
    while (at + 1 < text.size() && text[at + 1] == ' ') ++at;
    if (!folded.empty() && folded.back() == ',') folded += ' ';
  }
  return folded + "\n";
}

}  // namespace

std::string heights_text(const ScanPlan& plan, const ScanResult& result) {
  const std::size_t per_cell = steps_per_cell(plan, result.shape);
  std::string text = "# heights in metres over the plane of the plan of `thimble scan`\n";
  const std::size_t columns = (plan.columns - 1) * per_cell + 1, rows = (plan.rows - 1) * per_cell + 1;
  for (std::size_t row = rows; row-- > 0;) {  // the first row is at the back
    for (std::size_t column = 0; column < columns; ++column) {
      const double height_m =
          result.shape.height_m(Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row)) /
                                static_cast<double>(per_cell));
      std::array<char, 32> number{};
      const int size = std::snprintf(number.data(), number.size(), "%.6f", height_m);
      if (column != 0) text += ',';
      text.append(number.data(), static_cast<std::size_t>(size));
    }
    text += '\n';
  }
  return text;
}

std::string scene_text(const ScanPlan& plan, const ScanResult& result, const std::string& heights_file) {
  const double damping = result.damping ? std::max(result.damping->damping_N_s_m, 0.0) : plan.damping_N_s_m;
  double breakaway = plan.static_friction, sliding = plan.dynamic_friction;
  if (result.friction) {
    sliding = std::max(result.friction->sliding.coefficient, 0.0);
    breakaway = std::max(result.friction->breakaway.coefficient, sliding);
  }
  Json material;
  material["stiffness_N_m"] = tidy(result.mean_stiffness_N_m, 1e2);
  material["damping_N_s_m"] = tidy(damping, 1e3);
  material["static_friction"] = tidy(breakaway, 1e4);
  material["dynamic_friction"] = tidy(sliding, 1e4);
  if (result.friction)
    material["friction_mode"] = "steady";  // as the strokes are measured: at the mean force of sliding
  material["stiffness_map"] = stiffness_map(plan, result);
  Json scene;
  scene["thimble_scene"] = 1;
  scene["name"] = plan.name;
  scene["description"] = "Written by `thimble scan`: " + std::to_string(plan.columns) + " x " +
                         std::to_string(plan.rows) + " points, " + std::to_string(plan.cell_m) + " m apart.";
  Json object;
  object["name"] = plan.name;
  if (result.flat) {
    object["shape"]["plane"] = {{"normal", vector_json(result.normal, 1e9)},
                                {"offset_m", tidy(result.offset_m, 1e7)}};
  } else {
    const Eigen::Vector2d size_m = plan.cell_m * Eigen::Vector2d(static_cast<double>(plan.columns - 1),
                                                                 static_cast<double>(plan.rows - 1));
    object["shape"]["height_field"] = {
        {"file", heights_file}, {"size_m", {tidy(size_m.x(), 1e7), tidy(size_m.y(), 1e7)}}, {"height_m", 1}};
    object["pose"] = {
        {"position_m", vector_json(plan.origin_m + size_m.x() / 2 * plan.u + size_m.y() / 2 * plan.v, 1e7)},
        {"rotation_deg", vector_json(rotation_deg(plan), 1e6)}};
  }
  object["material"] = material;
  scene["objects"] = Json::array({object});
  return folded(scene.dump(2));
}

}  // namespace thimble::host
