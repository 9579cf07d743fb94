// What the surface does at one point, from the forces of a press and its way back: stiffness, in one layer or two, the surface's position,
// and what the ways differ by. Used by `thimble scan`. Cannot fail, but may find no contact.
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

// F = stiffness (depth) up to boundary_m, and with the slope below_N_m below it.
struct LayerFit {
  double below_N_m = 0;
  double boundary_m = 0;     // depth where the lower layer begins
  double residual_part = 1;  // residual over that of one slope
};

struct StiffnessFit {
  double stiffness_N_m = 0;               // along the approach; of the upper layer if there are two
  double contact_m = 0;                   // where the surface is, along the approach
  double depth_m = 0;                     // how deep the tip went
  double free_from_m = 0, free_to_m = 0;  // places of free motion at even speed, along the approach
  double start_m = 0;                     // where the move began
  double residual_N = 0;                  // RMS of the force off the lines
  double hysteresis_N =
      0;  // half the force between the way in and back: damping, and friction that the arm's model missed
  double free_hysteresis_N = 0;  // the same in free motion: friction only
  double tip_speed_m_s = 0;      // mean in contact, both ways
  std::optional<LayerFit> layer;
  std::size_t samples = 0;  // that the lines are of

  // Of the springs, at a depth.
  [[nodiscard]] double force_N(double at_m) const;
  // The one stiffness that is nearest to the forces from the surface to the depth, and how far it is off them at most.
  struct Single {
    double stiffness_N_m = 0, off_N = 0;
  };
  [[nodiscard]] Single single(double down_to_m) const;
};

// One slope, from the depths between 15 and 95 % of the deepest: the surface's edge and the turn are left out. Two slopes if they leave
// less than kLayered of the residual. speed_m_s: of the move; 0: no tip_speed_m_s is wanted.
// No value: the force stayed below kLeastPeak_N, or a line has fewer than kLeastSamples.
inline constexpr double kLeastPeak_N = 0.15;
inline constexpr std::size_t kLeastSamples = 4;
inline constexpr double kLayered = 0.5;
[[nodiscard]] std::optional<StiffnessFit> fit_stiffness(std::span<const ProbeSample> samples,
                                                        double speed_m_s = 0);

// The same with layers that are known: all points of a specimen have them, which tells more than one point does.
struct Layers {
  double ratio = 1;       // of the slopes, lower over upper
  double boundary_m = 0;  // depth
};
void refit_layers(std::span<const ProbeSample> samples, const Layers& layers, double speed_m_s,
                  StiffnessFit& fit);
// Without layers, whatever the press alone seems to say.
[[nodiscard]] std::optional<StiffnessFit> fit_one_slope(std::span<const ProbeSample> samples,
                                                        double speed_m_s);

}  // namespace thimble::host
