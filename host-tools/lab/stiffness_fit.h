// Stiffness from one guarded move: force against place on the way in and back, a line each, one slope for both.
// Joint friction shifts the two lines apart and leaves the slope alone; where they meet the force of free motion is
// the surface. Used by the scan, a point at a time. Units: m, N; cannot fail, but may find no contact.
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
// Nothing: the force stayed below kLeastPeak_N, or fewer than kLeastSamples are in a line.
inline constexpr double kLeastPeak_N = 0.15;
inline constexpr std::size_t kLeastSamples = 4;
[[nodiscard]] std::optional<StiffnessFit> fit_stiffness(std::span<const ProbeSample> samples);

}  // namespace thimble::host
