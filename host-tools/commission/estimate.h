// Estimators: pure functions from what a bench recorded to the numbers of an axis. Units: SI at the axis, rad (m and N where it is prismatic). `accepted` is
// false where the numbers cannot be: a negative friction, mass or stiffness, or too few measurements; the others are not to be used then.
//
// What they promise, of the value: Coulomb 20 %, viscous 30 % and 4 % of what Coulomb's takes at 2 rad/s, stiction 20 %, torque scale 5 %, inertia
// 10 %, stiffness 10 %, resonance 3 %, its damping 30 %, a change of the delay 0.1 tick. tests/closed_loop/commission holds them to it on simulated arms, with quantisation, friction and delay.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace thimble::host {

// Mean torques at a constant speed, there and back through the same place.
struct Sweep {
  double speed = 0;  // above 0
  double up_N_m = 0, down_N_m = 0;
};
struct FrictionFit {
  double coulomb_N_m = 0, viscous_N_m_s_rad = 0;
  double residual = 0;  // rms, of the Coulomb friction
  bool accepted = false;
};
// (up - down) / 2 = coulomb + viscous speed, by least squares. Weight cancels.
[[nodiscard]] FrictionFit fit_friction(std::span<const Sweep> sweeps);

// Factor between two sets of torques that should be the same: measured = scale * expected, by least squares.
struct ScaleFit {
  double scale = 1;
  double residual = 0;  // rms, of the largest expected
  bool accepted = false;
};
[[nodiscard]] ScaleFit fit_scale(std::span<const double> measured, std::span<const double> expected);

// The component of a recorded motion at one frequency, by the torque's; a straight line through the motion is taken out.
struct Response {
  double Hz = 0;
  std::complex<double> angle_per_torque{};  // rad/(N m)
  double amplitude = 0;                     // of the motion
};
[[nodiscard]] Response response_at(double Hz, double tick_s, std::span<const double> torque_N_m,
                                   std::span<const double> angle);

// A rotor with friction drives a link through a spring and a damper.
struct TwoMass {
  double rotor_kg_m2 = 0, link_kg_m2 = 0;
  double stiffness_N_m_rad = 0;
  double damping_ratio = 0;  // of the link on the spring, with the rotor held
  double locked_Hz =
      0;  // of the link with the rotor held: the first resonance of the arm with its motors locked
  double free_Hz = 0;   // of both against each other
  double delay_s = 0;   // from the torque asked for to the counts, without the hold of a tick
  double residual = 0;  // rms of the logarithm of measured by model
  bool accepted = false;
};
// hold_s: for which a torque is held, the tick. The friction of the rotor is known; what Coulomb's takes at an amplitude is a damper of that
// amplitude (describing function). inertia: of both, as a start.
[[nodiscard]] TwoMass fit_two_mass(std::span<const Response> responses, double inertia_kg_m2,
                                   const FrictionFit& friction, double hold_s);
// What the model answers.
[[nodiscard]] std::complex<double> answer(const TwoMass& mass, double viscous_N_m_s_rad, double hold_s,
                                          double Hz);

[[nodiscard]] double mean(std::span<const double> values);
[[nodiscard]] double spread(
    std::span<const double> values);                      // standard deviation of one; 0 for fewer than two
[[nodiscard]] double median(std::vector<double> values);  // 0 of none

}  // namespace thimble::host
