// What a scan found: the shape, and at each point the stiffness; damping and friction of the whole; and how far the measurements are off
// what describes them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "host-tools/lab/friction_fit.h"
#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_plan.h"
#include "host-tools/lab/scan_shape.h"
#include "host-tools/lab/stiffness_fit.h"

namespace thimble::host {

// Between the approach and the surface's normal. Within it a press along the approach is one along the normal: the cosine's square is
// 0.997, and friction holds the tip.
inline constexpr double kAligned_deg = 3;
// The steepest that is pressed along its normal.
inline constexpr double kSteepest_deg = 60;

// The line of a press along the surface's normal.
struct Aim {
  Eigen::Vector3d surface_m;
  Eigen::Vector3d normal;
};

// The contact positions by the presses along the approach, in the plan's order. Error kRefused names points without contact.
[[nodiscard]] std::vector<Eigen::Vector3d> approach_contacts(const ScanPlan& plan, const ScanLog& log);
// Where to press again: nothing for a point whose normal is along the approach. Error kRefused: too steep.
[[nodiscard]] std::optional<Aim> aim_at(const ScanPlan& plan, const ScannedShape& shape, std::size_t point);
[[nodiscard]] Aim aim_at_site(const ScannedShape& shape, const Eigen::Vector2d& site);
// The fit of a press along -aim.normal; its contact_m is along that direction from aim.surface_m.
[[nodiscard]] std::optional<StiffnessFit> fit_press(const Aim& aim, const ProbedMove& press, double speed_m_s,
                                                    const std::optional<Layers>& layers = std::nullopt);
// The best contact of each point: of the press along the normal if there is one.
[[nodiscard]] std::vector<Eigen::Vector3d> best_contacts(const ScanPlan& plan, const ScanLog& log);

struct ScannedPoint {
  StiffnessFit fit;
  Eigen::Vector3d contact_m;
  double stiffness_N_m = 0;  // of the scene, along the normal
  double lean_deg = 0;       // of the press from the normal
};

struct FrictionResult {
  CoefficientFit breakaway, sliding;
};

struct ScanResult {
  ScannedShape shape;
  std::vector<ScannedPoint> points;  // in the plan's order
  Eigen::Vector3d normal;            // of the plane through the contacts
  double offset_m = 0;               // normal . p = offset_m on it
  double off_plane_rms_m = 0, off_plane_most_m = 0;
  // The shape between the points, off the contacts at the sites.
  std::size_t checks = 0;
  double check_rms_m = 0, check_most_m = 0;
  double least_stiffness_N_m = 0, most_stiffness_N_m = 0, mean_stiffness_N_m = 0;
  double residual_N = 0, hysteresis_N = 0;  // the most of all points
  // Of a layered specimen; the stiffnesses are means over the points. The scene has one stiffness, nearest to the forces down to
  // depth_m, and off them by at most off_N.
  std::optional<Layers> layers = std::nullopt;
  double upper_N_m = 0, lower_N_m = 0, depth_m = 0, off_N = 0;
  std::optional<DampingFit> damping = std::nullopt;  // none: the plan gives it
  std::optional<FrictionResult> friction =
      std::nullopt;   // none: the plan gives it, or no site could be measured
  bool flat = false;  // off_plane_most_m is within kFlat_m: the scene has a plane

  // Of the contact of a point over the plan's surface, against its approach.
  [[nodiscard]] double height_m(const ScanPlan& plan, std::size_t point) const;
  [[nodiscard]] std::vector<double> stiffness_map(const ScanPlan& plan) const;  // u fastest
};

// Within it a plane describes the specimen.
inline constexpr double kFlat_m = 2e-4;

// Of a complete log. Error kRefused names points without contact.
[[nodiscard]] ScanResult result_of(const ScanPlan& plan, const ScanLog& log);

}  // namespace thimble::host
