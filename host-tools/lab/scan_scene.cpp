#include "host-tools/lab/scan_scene.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "control/scene/limits.h"
#include "host-tools/error.h"
#include "host-tools/lab/spline.h"

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

// Rounded below what a scan resolves.
double tidy(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }

Json vector_json(const Eigen::Vector3d& v, double per_unit) {
  return {tidy(v.x(), per_unit), tidy(v.y(), per_unit), tidy(v.z(), per_unit)};
}

}  // namespace

std::optional<StiffnessFit> fit_point(const ScanPlan& plan, const ProbedPoint& point) {
  const Eigen::Vector3d nominal_m = plan.place_m(plan.column_of(point.point), plan.row_of(point.point));
  std::vector<ProbeSample> samples;
  for (const PointSample& sample : point.samples)
    samples.push_back({sample.pressing, (sample.tip_m - nominal_m).dot(plan.approach), sample.force_N});
  return fit_stiffness(samples);
}

ScannedSurface surface_of(const ScanPlan& plan, std::span<const StiffnessFit> fits) {
  ScannedSurface surface;
  const std::size_t points = plan.points();
  surface.stiffness_N_m.resize(points);
  surface.height_m.resize(points);
  std::vector<Eigen::Vector3d> contacts;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points; ++i) {
    contacts.emplace_back(plan.place_m(plan.column_of(i), plan.row_of(i)) +
                          fits[i].contact_m * plan.approach);
    centre_m += contacts.back() / static_cast<double>(points);
  }
  // Least squares of the height along u x v over the grid: h = c0 u + c1 v about the centre.
  const Eigen::Vector3d up = plan.u.cross(plan.v).normalized();
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& contact : contacts) {
    const Eigen::Vector2d at((contact - centre_m).dot(plan.u), (contact - centre_m).dot(plan.v));
    A += at * at.transpose();
    b += at * (contact - centre_m).dot(up);
  }
  const Eigen::Vector2d slope = A.inverse() * b;
  surface.normal = (up - slope.x() * plan.u - slope.y() * plan.v).normalized();
  surface.offset_m = surface.normal.dot(centre_m);
  const double cosine = surface.normal.dot(plan.approach);
  for (std::size_t i = 0; i < points; ++i) {
    const double off_m = surface.normal.dot(contacts[i]) - surface.offset_m;
    surface.off_plane_rms_m += off_m * off_m / static_cast<double>(points);
    surface.off_plane_most_m = std::max(surface.off_plane_most_m, std::abs(off_m));
    const std::size_t place = plan.row_of(i) * plan.columns + plan.column_of(i);
    surface.stiffness_N_m[place] = fits[i].stiffness_N_m / (cosine * cosine);
    surface.height_m[place] = -fits[i].contact_m;
  }
  surface.off_plane_rms_m = std::sqrt(surface.off_plane_rms_m);
  return surface;
}

std::string scene_text(const ScanPlan& plan, const ScannedSurface& surface) {
  const std::vector<double> control = spline_control_points(surface.stiffness_N_m, plan.columns, plan.rows);
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
  const double mean = std::accumulate(surface.stiffness_N_m.begin(), surface.stiffness_N_m.end(), 0.0) /
                      static_cast<double>(plan.points());
  Json map;
  map["cell_m"] = plan.cell_m;
  map["origin_m"] = vector_json(plan.place_m(0, 0) - plan.cell_m * (plan.u + plan.v), 1e7);
  map["u"] = vector_json(plan.u, 1e9);
  map["v"] = vector_json(plan.v, 1e9);
  map["conservative"] = plan.conservative;
  map["stiffness_N_m"] = rows;
  Json material;
  material["stiffness_N_m"] = tidy(mean, 1e2);
  material["damping_N_s_m"] = plan.damping_N_s_m;
  material["static_friction"] = plan.static_friction;
  material["dynamic_friction"] = plan.dynamic_friction;
  material["stiffness_map"] = map;
  Json scene;
  scene["thimble_scene"] = 1;
  scene["name"] = plan.name;
  scene["description"] = "Written by `thimble scan`: " + std::to_string(plan.columns) + " x " +
                         std::to_string(plan.rows) + " points, " + std::to_string(plan.cell_m) + " m apart.";
  Json object;
  object["name"] = plan.name;
  object["shape"]["plane"] = {{"normal", vector_json(surface.normal, 1e9)},
                              {"offset_m", tidy(surface.offset_m, 1e7)}};
  object["material"] = material;
  scene["objects"] = Json::array({object});

  // One row of the map a line.
  std::string text = scene.dump(2);
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

}  // namespace thimble::host
