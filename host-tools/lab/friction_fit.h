// Damping and friction from what the presses and strokes of a scan measured. Used by `thimble scan`.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_shape.h"
#include "host-tools/lab/stiffness_fit.h"

namespace thimble::host {

// The force between the ways in and back, beyond that of free motion at the same speed of the arm, over the tip's speed.
struct DampingFit {
  double damping_N_s_m = 0;
  double uncertainty_N_s_m = 0;  // what friction of the arm can be taken for
  double residual_N = 0;         // RMS
  std::size_t presses = 0;
};
[[nodiscard]] DampingFit fit_damping(std::span<const StiffnessFit> presses);

// One stroke, or one out and back.
struct StrokeForce {
  std::size_t site = 0;
  double normal_N = 0;
  double along_N = 0;
};
// along = offset(site) + coefficient x normal: what the arm's own friction adds is the same for each load.
struct CoefficientFit {
  double coefficient = 0;
  double spread = 0;      // standard deviation over the sites
  double residual_N = 0;  // RMS of `along`
  std::size_t strokes = 0;
};
// No value: no site has strokes of two loads.
[[nodiscard]] std::optional<CoefficientFit> fit_coefficient(std::span<const StrokeForce> strokes);

// What the strokes of one site say. fit, contact_m: of its press along the normal.
struct SiteForces {
  std::vector<StrokeForce> breakaway, sliding;
};
[[nodiscard]] SiteForces site_forces(const ProbedStep& step, std::size_t number, const StiffnessFit& fit,
                                     const ScannedShape& shape, const Eigen::Vector3d& contact_m);

}  // namespace thimble::host
