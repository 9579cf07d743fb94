// A mass dragged by a spring over a surface with friction (paper, section 3.6): the slip frequency, also in
// the spectrum of the force.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

constexpr double kStatic = 0.6;
constexpr double kDynamic = 0.4;

std::string rough(double stiffness_N_m, const char* mode) {
  return "\"stiffness_N_m\": " + std::to_string(stiffness_N_m) +
         ", \"static_friction\": " + std::to_string(kStatic) +
         ", \"dynamic_friction\": " + std::to_string(kDynamic) + ", \"friction_mode\": \"" + mode + "\"";
}

struct Drive {
  double mass_kg;
  double spring_N_m;
  double damper_N_s_m;  // beside the spring
  double speed_m_s;
  double press_N;
  double seconds;
};

// The force along the way, tick by tick, once the mass has settled into its cycle.
std::vector<double> drag(IdealRun& run, const Drive& drive, double stiffness_N_m) {
  Mass mass{drive.mass_kg, {0, 0, -drive.press_N / stiffness_N_m}, {0, 0, 0}};
  run.restart({0, 0, 1e-4});
  std::vector<double> force_N;
  const double settle_s = drive.seconds / 3.0;
  for (double t = 0; t < settle_s + drive.seconds; t += 1.0 / kRate_Hz) {
    const double ahead_m = drive.speed_m_s * t - mass.position_m.x();
    const double closing_m_s = drive.speed_m_s - mass.velocity_m_s.x();
    // Pressed with a constant force, its bouncing damped.
    const Vector3d pull(drive.spring_N_m * ahead_m + drive.damper_N_s_m * closing_m_s, 0,
                        -drive.press_N - 5.0 * mass.velocity_m_s.z());
    const Felt& felt = mass.step(run, pull);
    if (t >= settle_s) force_N.push_back(felt.force_N.x());
  }
  return force_N;
}

// Slips: the force falls by a good part of what it may fall.
double slips_per_second(const std::vector<double>& force_N, double fall_N) {
  int first = -1;
  int last = -1;
  int count = 0;
  double lowest = force_N.front();  // most resistance since the last slip
  for (std::size_t i = 0; i < force_N.size(); ++i) {
    lowest = std::min(lowest, force_N[i]);
    if (force_N[i] > lowest + 0.6 * fall_N) {
      lowest = force_N[i];
      if (first < 0) first = static_cast<int>(i);
      last = static_cast<int>(i);
      ++count;
    }
  }
  return count > 1 ? (count - 1) * kRate_Hz / (last - first) : 0.0;
}

// The paper's friction: each slip moves the stiction point on by (mu_s - mu_d) F_n / K, so at a mean speed V
// there are V K / ((mu_s - mu_d) F_n) of them a second, whatever mass and spring do in between.
TEST(StickSlip, ThePapersFrictionSlipsAtVKOverTheFallOfTheForce) {
  constexpr double kStiffness_N_m = 1000.0;
  const SceneImage image = surface_scene(rough(kStiffness_N_m, "stick_slip"));
  for (const double speed_m_s : {0.01, 0.02, 0.04}) {
    for (const double press_N : {1.0, 2.0}) {
      IdealRun run(image);
      const Drive drive{0.01, 400, 6, speed_m_s, press_N, 2};
      const std::vector<double> force_N = drag(run, drive, kStiffness_N_m);
      const double closed_Hz = speed_m_s * kStiffness_N_m / ((kStatic - kDynamic) * press_N);
      const double slips_Hz = slips_per_second(force_N, (kStatic - kDynamic) * press_N);
      const double peak_Hz = peak_frequency(force_N, kRate_Hz, 0.3 * closed_Hz, 3.0 * closed_Hz, 600);
      const std::string at =
          " at " + std::to_string(speed_m_s) + " m/s, " + std::to_string(press_N) + " N, Hz";
      const std::string limit = std::to_string(closed_Hz) + " within 5 %";
      figure("slips" + at, slips_Hz, limit);
      figure("peak of the force's spectrum" + at, peak_Hz, limit);
      const double share = amplitude(force_N, kRate_Hz, peak_Hz) / ((kStatic - kDynamic) * press_N);
      figure("its amplitude over the force's fall", share, "> 0.1; a sawtooth has 1 / pi");
      EXPECT_NEAR(slips_Hz, closed_Hz, 0.05 * closed_Hz);
      EXPECT_NEAR(peak_Hz, closed_Hz, 0.05 * closed_Hz);
      EXPECT_GT(share, 0.1);
    }
  }
}

// Coulomb friction: the classical driven mass on a spring k with a damper c. It sticks while k z + c V grows
// to mu_s F_n, z = V t - x; then m z'' + c z' + k z = mu_d F_n from z' = V until z' = V again, where the mass
// stands still. z is a damped sine about mu_d F_n / k, and the sticking lasts (z_slip - z_stop) / V. The
// surface's own spring K holds the stuck mass: k K / (k + K).
double classical_period_s(const Drive& d, double stiffness_N_m) {
  const double omega = std::sqrt(d.spring_N_m / d.mass_kg);
  const double sigma = d.damper_N_s_m / (2.0 * d.mass_kg);
  const double ring = std::sqrt(omega * omega - sigma * sigma);
  const double middle_m = kDynamic * d.press_N / d.spring_N_m;
  const double slip_m = (kStatic * d.press_N - d.damper_N_s_m * d.speed_m_s) / d.spring_N_m;
  const double a = slip_m - middle_m;
  const double b = (d.speed_m_s + sigma * a) / ring;
  const auto speed = [&](double t) {
    return std::exp(-sigma * t) *
           ((ring * b - sigma * a) * std::cos(ring * t) - (ring * a + sigma * b) * std::sin(ring * t));
  };
  double low = 1e-3 / ring;  // just after the start the mass moves, z' < V
  while (speed(low) < d.speed_m_s && ring * low < 6.0) low += 1e-4 / ring;
  const double stop_m =
      middle_m + std::exp(-sigma * low) * (a * std::cos(ring * low) + b * std::sin(ring * low));
  return low + (slip_m - stop_m) / d.speed_m_s * (1.0 + d.spring_N_m / stiffness_N_m);
}

TEST(StickSlip, CoulombFrictionSlipsAsTheDrivenMassOnASpring) {
  constexpr double kStiffness_N_m =
      8000.0;  // held for a tick it drives by K T / 2 = 1 N s/m, which the damper outdoes
  const SceneImage image = surface_scene(rough(kStiffness_N_m, "steady"));
  for (const double speed_m_s : {0.0015, 0.0025, 0.004}) {
    IdealRun run(image);
    const Drive drive{0.2, 400, 8, speed_m_s, 4, 12};
    const std::vector<double> force_N = drag(run, drive, kStiffness_N_m);
    const double closed_Hz = 1.0 / classical_period_s(drive, kStiffness_N_m);
    const double slips_Hz = slips_per_second(force_N, (kStatic - kDynamic) * drive.press_N);
    const double peak_Hz = peak_frequency(force_N, kRate_Hz, 0.5 * closed_Hz, 5.0 * closed_Hz, 450);
    const std::string at = " of a driven mass on a spring at " + std::to_string(speed_m_s) + " m/s, Hz";
    figure("slips" + at, slips_Hz, std::to_string(closed_Hz) + " within 5 %");
    figure("peak of the force's spectrum" + at, peak_Hz, std::to_string(closed_Hz) + " within 5 %");
    EXPECT_NEAR(slips_Hz, closed_Hz, 0.05 * closed_Hz);
    EXPECT_NEAR(peak_Hz, closed_Hz, 0.05 * closed_Hz);
  }
}

TEST(StickSlip, IceDoesNot) {
  const SceneImage image = surface_scene("\"stiffness_N_m\": 1000");
  IdealRun run(image);
  double most_N = 0;
  for (const double force_N : drag(run, {0.02, 400, 4, 0.02, 2, 1}, 1000))
    most_N = std::max(most_N, std::abs(force_N));
  figure("tangential force on a frictionless surface, N", most_N, "0");
  EXPECT_EQ(most_N, 0.0);
}

}  // namespace
}  // namespace thimble::test
