#include "host-tools/lab/scan_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "firmware/link/crc32.h"
#include "firmware/link/services.h"
#include "host-tools/compiler/scene_value.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

constexpr std::array<std::string_view, 23> kPlanKeys = {"thimble_scan",
                                                        "name",
                                                        "description",
                                                        "origin_m",
                                                        "u",
                                                        "v",
                                                        "approach",
                                                        "columns",
                                                        "rows",
                                                        "cell_m",
                                                        "clearance_m",
                                                        "depth_m",
                                                        "force_limit_N",
                                                        "speed_m_s",
                                                        "travel_speed_m_s",
                                                        "arm",
                                                        "material",
                                                        "conservative",
                                                        "friction",
                                                        "friction_sites",
                                                        "stroke_m",
                                                        "slow_stroke_m_s",
                                                        "fast_stroke_m_s"};
constexpr std::array<std::string_view, 3> kMaterialKeys = {"damping_N_s_m", "static_friction",
                                                           "dynamic_friction"};
constexpr std::size_t kMostPoints = 4096;
constexpr double kSquare = 1e-3;          // u . v
constexpr double kLeastIntoCosine = 0.5;  // of approach against the normal
constexpr std::size_t kMostSites = 16;
constexpr double kStroke_m = 0.008;  // enough to break away from 200 N/m at a coefficient of 1
constexpr Range kStrokeLength{1e-3, 0.03, "m"};
constexpr Range kWay{5e-4, 0.1, "m"};
constexpr Range kSpeed{static_cast<double>(link::kMinMoveSpeed_m_s),
                       static_cast<double>(link::kMaxMoveSpeed_m_s), "m/s"};
constexpr Range kForce{static_cast<double>(link::kMinMoveForce_N), static_cast<double>(link::kMaxMoveForce_N),
                       "N"};

std::size_t count(const Value& value, std::size_t least, std::size_t most) {
  return static_cast<std::size_t>(value.integer(static_cast<int>(least), static_cast<int>(most)));
}

ScanPlan read_plan(const Value& root) {
  root.object("a scan plan", kPlanKeys);
  if (root.at("thimble_scan").raw() != 1) root.at("thimble_scan").wrong("1");
  ScanPlan plan;
  plan.name = root.at("name").text(64);
  plan.origin_m = root.at("origin_m").vector(kCoordinate);
  plan.u = root.at("u").direction();
  plan.v = root.at("v").direction();
  if (std::abs(plan.u.dot(plan.v)) > kSquare) root.at("v").wrong("a direction square to u");
  const Eigen::Vector3d normal = plan.u.cross(plan.v).normalized();
  plan.approach = root.has("approach") ? root.at("approach").direction() : Eigen::Vector3d(-normal);
  if (-plan.approach.dot(normal) < kLeastIntoCosine)
    root.at("approach").wrong("a direction into the surface, within 60 degrees of -(u x v)");
  plan.v = normal.cross(plan.u);
  plan.columns = count(root.at("columns"), 2, kMostPoints / 2);
  plan.rows = count(root.at("rows"), 2, kMostPoints / plan.columns);
  plan.cell_m = root.at("cell_m").number(kWay);
  plan.clearance_m = root.at("clearance_m").number(kWay);
  plan.depth_m = root.at("depth_m").number(kWay);
  plan.force_limit_N = root.at("force_limit_N").number(kForce);
  plan.speed_m_s = root.at("speed_m_s").number(kSpeed);
  plan.travel_speed_m_s = root.number_or("travel_speed_m_s", kSpeed, kSpeed.most);
  if (root.has("arm")) plan.arm = static_cast<std::uint8_t>(count(root.at("arm"), 0, control::kMaxArms - 1));
  if (root.has("material")) {
    const Value material = root.at("material");
    material.object("the scan's material", kMaterialKeys);
    constexpr Range kFriction{0, static_cast<double>(control::kMaxFriction)};
    plan.measure_damping = !material.has("damping_N_s_m");
    plan.measure_friction = !material.has("static_friction") && !material.has("dynamic_friction");
    plan.damping_N_s_m =
        material.number_or("damping_N_s_m", {0, static_cast<double>(control::kMaxDamping_N_s_m), "N s/m"}, 0);
    plan.static_friction = material.number_or("static_friction", kFriction, 0);
    plan.dynamic_friction = material.number_or("dynamic_friction", kFriction, plan.static_friction);
  }
  if (root.has("friction")) {
    const bool wanted = root.at("friction").boolean();
    if (wanted && !plan.measure_friction)
      root.at("friction").wrong("false, because the material gives the coefficients");
    plan.measure_friction = wanted;
  }
  if (root.has("friction_sites")) plan.most_sites = count(root.at("friction_sites"), 1, kMostSites);
  plan.stroke_m = root.number_or("stroke_m", kStrokeLength, std::min(kStroke_m, plan.cell_m));
  plan.slow_stroke_m_s = root.number_or("slow_stroke_m_s", kSpeed, plan.slow_stroke_m_s);
  plan.fast_stroke_m_s = root.number_or("fast_stroke_m_s", kSpeed, plan.fast_stroke_m_s);
  if (root.has("conservative")) plan.conservative = root.at("conservative").boolean();
  return plan;
}

}  // namespace

Eigen::Vector3d ScanPlan::normal() const { return u.cross(v).normalized(); }

std::string ScanPlan::named(std::size_t point) const {
  return "point " + std::to_string(point) + " (column " + std::to_string(column_of(point)) + ", row " +
         std::to_string(row_of(point)) + ")";
}

std::vector<Eigen::Vector2d> ScanPlan::sites() const {
  std::vector<Eigen::Vector2d> places;
  if (!measure_friction) return places;
  // A grid of sites, with about as many along u as along v, spread over the cells.
  const std::size_t wide = columns - 1, deep = rows - 1;
  auto across = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(most_sites))));
  across = std::min(across, wide);
  const std::size_t down = std::min(most_sites / across, deep);
  const auto middle = [](std::size_t i, std::size_t of, std::size_t cells) {
    const auto cell = (2 * i + 1) * cells / (2 * of);
    return static_cast<double>(cell) + 0.5;
  };
  for (std::size_t row = 0; row < down; ++row) {
    for (std::size_t column = 0; column < across; ++column)
      places.emplace_back(middle(column, across, wide), middle(row, down, deep));
  }
  return places;
}

ScanPlan read_scan_plan_text(const std::string& text, const std::string& name) {
  try {
    const board::JsonDocument document(text, name, "the plan");
    ScanPlan plan = read_plan(Value(document));
    plan.crc = link::crc32(std::as_bytes(std::span(text)));
    return plan;
  } catch (const board::JsonError& error) {
    throw to_error(error);
  }
}

ScanPlan read_scan_plan(const std::filesystem::path& file) {
  return read_scan_plan_text(read_input(file), file.string());
}

}  // namespace thimble::host
