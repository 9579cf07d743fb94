// Stiffness from one guarded move: a line is fitted to force against position on the way in, and another on the way back, with one
// common slope. Joint friction shifts the lines apart and does not change the slope. The surface is where the lines reach the
// force of free motion. Used by the scan for each point. Units: m, N. Cannot fail, but may find no contact.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace thimble::host {

struct ProbeSample {
  bool pressing = false;  // on the way in
  double along_m = 0;     // place along the approach
  double force_N = 0;     // along the approach, of the arm on the specimen
};

struct StiffnessFit {
  double stiffness_N_m = 0;  // along the approach
  double contact_m = 0;      // where the surface is, along the approach
  double residual_N = 0;     // RMS of the force off the lines
  double hysteresis_N =
      0;  // half the force between the way in and back: friction that the arm's model missed
  std::size_t samples = 0;  // that the lines are of
};

// The lines are of the depths between 15 and 95 % of the deepest: the surface's edge and the turn are left out.
// No value: the force stayed below kLeastPeak_N, or a line has fewer than kLeastSamples.
inline constexpr double kLeastPeak_N = 0.15;
inline constexpr std::size_t kLeastSamples = 4;
[[nodiscard]] std::optional<StiffnessFit> fit_stiffness(std::span<const ProbeSample> samples);

}  // namespace thimble::host
