// Writes the scene of a scan: a height field through the points of contact, or a plane for a flat specimen, with a stiffness_map that
// interpolates the stiffness found at each point, and the damping and friction that were found.
#pragma once

#include <string>

#include "host-tools/lab/scan_plan.h"
#include "host-tools/lab/scan_result.h"

namespace thimble::host {

// The rows of heights of the height field, a CSV file in metres. Between two rows the shape is within kGridError_m of straight lines.
inline constexpr double kGridError_m = 1e-5;
[[nodiscard]] std::string heights_text(const ScanPlan& plan, const ScanResult& result);

// The scene file's text. heights_file: the file of heights, as the scene names it; not used for a flat specimen. Error kRefused when the
// spline through the stiffness leaves what a scene may have.
[[nodiscard]] std::string scene_text(const ScanPlan& plan, const ScanResult& result,
                                     const std::string& heights_file);

}  // namespace thimble::host
