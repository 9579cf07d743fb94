// What is to be scanned, and how: the plan file of `thimble scan`, JSON like a scene file (docs/scan.md has the keys).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace thimble::host {

struct ScanPlan {
  std::string name;
  Eigen::Vector3d origin_m;  // of the first point, on the surface as it is thought to be
  Eigen::Vector3d u, v;      // unit, square to each other
  Eigen::Vector3d approach;  // unit, into the surface
  std::size_t columns = 0, rows = 0;
  double cell_m = 0;
  double clearance_m = 0;  // a move begins so far before the surface
  double depth_m = 0;      // and ends so far behind it, unless the force limit comes first
  double force_limit_N = 0;
  double speed_m_s = 0;
  double travel_speed_m_s = 0;
  std::uint8_t arm = 0;
  // Of the scene that is written; what the plan gives is not measured.
  double damping_N_s_m = 0, static_friction = 0, dynamic_friction = 0;
  bool measure_damping = true;
  bool measure_friction = true;    // by strokes at the sites
  std::size_t most_sites = 4;      // where the friction is measured
  double stroke_m = 0;             // length of a stroke
  double slow_stroke_m_s = 0.006;  // until the tip breaks away: static friction
  double fast_stroke_m_s = 0.025;  // dynamic friction
  bool conservative = true;
  std::uint32_t crc = 0;  // of the file's text: a log belongs to one plan

  [[nodiscard]] std::size_t points() const { return columns * rows; }
  // Boustrophedon, so that neighbours in time are neighbours in space.
  [[nodiscard]] std::size_t column_of(std::size_t point) const {
    const std::size_t along = point % columns;
    return row_of(point) % 2 == 0 ? along : columns - 1 - along;
  }
  [[nodiscard]] std::size_t row_of(std::size_t point) const { return point / columns; }
  [[nodiscard]] Eigen::Vector3d place_m(std::size_t column, std::size_t row) const {
    return origin_m + cell_m * (static_cast<double>(column) * u + static_cast<double>(row) * v);
  }
  [[nodiscard]] Eigen::Vector3d normal() const;              // u x v
  [[nodiscard]] std::string named(std::size_t point) const;  // "point 3 (column 3, row 0)"

  // Where the friction is measured: the middles of cells, in cells from the first point. None if it is not measured.
  [[nodiscard]] std::vector<Eigen::Vector2d> sites() const;

  // A scan is a row of steps: first a press at each point along the approach; then again, along the surface's normal, at the
  // points where the two differ; then the sites.
  [[nodiscard]] std::size_t steps() const { return 2 * points() + sites().size(); }
  [[nodiscard]] bool is_site(std::size_t step) const { return step >= 2 * points(); }
};

// Error kBadInput with file, line, JSON pointer, the value and what is allowed.
[[nodiscard]] ScanPlan read_scan_plan(const std::filesystem::path& file);
[[nodiscard]] ScanPlan read_scan_plan_text(const std::string& text, const std::string& name);

}  // namespace thimble::host
