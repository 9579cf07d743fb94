// Makes a scene from the measurements of a scan: a plane through the points of first contact, with a stiffness map that
// interpolates the stiffness found at each point.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_plan.h"
#include "host-tools/lab/stiffness_fit.h"

namespace thimble::host {

// The samples of one point, along the plan's approach from the surface as the plan has it.
[[nodiscard]] std::optional<StiffnessFit> fit_point(const ScanPlan& plan, const ProbedPoint& point);

struct ScannedSurface {
  Eigen::Vector3d normal;      // of the plane through the contacts
  double offset_m = 0;         // normal . p = offset_m on it
  double off_plane_rms_m = 0;  // of the contacts
  double off_plane_most_m = 0;
  std::vector<double> stiffness_N_m;  // along the normal; u fastest
  std::vector<double> height_m;       // of each contact above the plan's surface, against its approach
};

// Above this deviation the specimen is not flat, and a plane does not describe it.
inline constexpr double kFlat_m = 3e-4;

// fits: in the order of the plan's points. Without friction the force is along the normal, so what is felt along the
// approach is K (n . a)^2.
[[nodiscard]] ScannedSurface surface_of(const ScanPlan& plan, std::span<const StiffnessFit> fits);

// The scene file's text. Error kRefused when the spline through the values leaves what a scene may have.
[[nodiscard]] std::string scene_text(const ScanPlan& plan, const ScannedSurface& surface);

}  // namespace thimble::host
