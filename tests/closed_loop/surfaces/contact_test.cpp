// Contact transients and impedance (paper, sections 3.1 to 3.4): onset, restitution, click and brake.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

constexpr double kPeriod_s = 1.0 / kRate_Hz;
constexpr const char* kClick = R"("click": {"amplitude_N": 0.8, "frequency_Hz": 200, "decay_per_s": 90})";

TEST(Contact, FreeSpaceIsFreeAndForceSetsInInTheTickOfEntry) {
  for (const std::string& extra : {std::string(), std::string(", ") + kClick}) {
    const SceneImage image = surface_scene("\"stiffness_N_m\": 1000, \"damping_N_s_m\": 2" + extra);
    IdealRun run(image);
    double free_N = 0;
    for (double z = 0.010012; z >= 0.0; z -= 2.5e-5)
      free_N = std::max(free_N, run.step({0, 0, z}).force_N.norm());
    const double above_m = run.felt().tip_m.z();
    const double entry_N = run.step({0, 0, above_m - 2.5e-5}).force_N.z();
    const double depth_m = -run.felt().tip_m.z();
    figure("largest force in free space, N", free_N, "0");
    figure("force in the tick of entry over K d", entry_N / (1000.0 * depth_m), ">= 1");
    EXPECT_EQ(free_N, 0.0);
    ASSERT_GT(depth_m, 0.0);
    EXPECT_GE(entry_N, 0.999 * 1000.0 * depth_m);
    for (int i = 0; i < 400; ++i) run.step(run.felt().tip_m + Vector3d(0, 0, 2.5e-5));
    EXPECT_EQ(run.felt().force_N.norm(), 0.0);
  }
}

// m x'' + B x' + K x = 0 until the wall would have to pull, from where on the mass goes on as it is:
// e = exp(-2 z acos(z) / sqrt(1 - z^2)), z = B / (2 sqrt(K m)).
TEST(Contact, RestitutionFallsWithDampingAsTheClosedFormSays) {
  constexpr double kMass_kg = 0.1;
  constexpr double kStiffness_N_m = 1000.0;
  for (const double damping : {0.0, 1.0, 2.0, 4.0, 8.0, 14.0}) {
    const SceneImage image =
        surface_scene("\"stiffness_N_m\": 1000, \"damping_N_s_m\": " + std::to_string(damping));
    IdealRun run(image);
    Mass mass{kMass_kg, {0, 0, 0.002}, {0, 0, -0.1}};
    bool touched = false;
    double most_pull_N = 0;
    for (int tick = 0; tick < 8000 && !(touched && mass.position_m.z() > 0.001); ++tick) {
      const Felt& felt = mass.step(run);
      touched = touched || felt.contacts > 0;
      most_pull_N = std::max(most_pull_N, -felt.force_N.z());
    }
    const double z = damping / (2.0 * std::sqrt(kStiffness_N_m * kMass_kg));
    const double closed = std::exp(-2.0 * z * std::acos(z) / std::sqrt(1.0 - z * z));
    const double restitution = mass.velocity_m_s.z() / 0.1;
    figure("restitution at B = " + std::to_string(damping) + " N s/m", restitution,
           std::to_string(closed) + " within 5 %");
    EXPECT_NEAR(restitution, closed, 0.05 * closed);
    EXPECT_LE(most_pull_N, 0.0);
  }
}

// The force with the click less the force without it, tick by tick, on one path.
TEST(Click, IsTheDecayingTransientThatWasAskedFor) {
  for (const double speed_m_s : {0.05, 0.1, 0.2}) {
    const SceneImage with = surface_scene(std::string("\"stiffness_N_m\": 1000, ") + kClick);
    const SceneImage without = surface_scene("\"stiffness_N_m\": 1000");
    IdealRun clicked(with);
    IdealRun plain(without);
    std::vector<double> transient;
    double worst_N = 0;
    const double amplitude_N = 0.8 * speed_m_s / 0.1;
    for (int tick = 0; tick < 700; ++tick) {
      const Vector3d p(0, 0, 0.001 - speed_m_s * kPeriod_s * tick);
      const double click_N = clicked.step(p).force_N.z() - plain.step(p).force_N.z();
      if (plain.felt().contacts == 0) {
        EXPECT_EQ(click_N, 0.0);
        continue;
      }
      const double t = kPeriod_s * static_cast<double>(transient.size());
      const double wanted_N =
          amplitude_N * std::exp(-90.0 * t) * std::sin(2.0 * std::numbers::pi * 200.0 * t);
      worst_N = std::max(worst_N, std::abs(click_N - wanted_N));
      transient.push_back(click_N);
    }
    const std::string at = " at " + std::to_string(speed_m_s) + " m/s";
    ASSERT_GT(transient.size(), 400U);
    figure("click: largest difference from A v exp(-B t) sin(2 pi f t)" + at + ", N", worst_N, "1 % of A v");
    EXPECT_LT(worst_N, 0.01 * amplitude_N);
    figure("click: frequency" + at + ", Hz", peak_frequency(transient, kRate_Hz, 100, 400), "200 within 2 %");
    EXPECT_NEAR(peak_frequency(transient, kRate_Hz, 100, 400), 200.0, 4.0);
  }
}

// A free mass thrown at an undamped wall again and again: the click must live on what the mass has spent on it.
TEST(Click, NeverGivesTheHandMoreThanItHasPutIn) {
  Random random(7);
  double worst_J = -1.0;
  double most_gain = 0.0;
  for (int impact = 0; impact < 200; ++impact) {
    const double stiffness_N_m = random.uniform(200, 2000);
    const std::string material =
        "\"stiffness_N_m\": " + std::to_string(stiffness_N_m) +
        ", \"click\": {\"amplitude_N\": " + std::to_string(random.uniform(0.2, 1.5)) +
        ", \"frequency_Hz\": " + std::to_string(random.uniform(40, 500)) +
        ", \"decay_per_s\": " + std::to_string(random.uniform(1, 200)) + "}";
    const SceneImage image = surface_scene(material);
    IdealRun run(image);
    Mass mass{random.uniform(0.02, 0.2), {0, 0, 0.001}, {0.1, 0, -random.uniform(0.02, 0.4)}};
    const double speed_m_s = mass.velocity_m_s.z();
    double given_J = 0;  // by the click alone: the force less the spring's
    for (int tick = 0; tick < 4000 && mass.position_m.z() < 0.0012; ++tick) {
      const Vector3d before = mass.position_m;
      const Felt& felt = mass.step(run);
      const double click_N = felt.force_N.z() - stiffness_N_m * std::max(-felt.tip_m.z(), 0.0);
      given_J += click_N * (mass.position_m.z() - before.z());
      worst_J = std::max(worst_J, given_J);
    }
    most_gain = std::max(most_gain, std::abs(mass.velocity_m_s.z() / speed_m_s));
  }
  figure("click: most that it had given the mass at any moment, J", worst_J,
         "1e-6, of impacts of 1e-5 to 1e-2");
  figure("click: largest restitution of 200 impacts", most_gain, "1.05: K T of the held spring");
  EXPECT_LT(worst_J, 1e-6);
  EXPECT_LT(most_gain, 1.05);
}

TEST(Click, RingsAgainOnlyAfterContactWasLost) {
  const SceneImage image = surface_scene(std::string("\"stiffness_N_m\": 1000, ") + kClick);
  IdealRun run(image);
  run.restart({0, 0, 0.001});
  run.move({0, 0, -0.002}, 2.5e-5);
  for (int i = 0; i < 2000; ++i) run.step(run.felt().tip_m);
  const double rest_N = run.felt().force_N.z();
  EXPECT_NEAR(rest_N, 2.0, 1e-4);
  double most_N = 0;
  for (int i = 0; i < 40; ++i) {  // deeper, still in contact
    run.step(run.felt().tip_m - Vector3d(0, 0, 2.5e-5));
    most_N = std::max(most_N, std::abs(run.felt().force_N.z() + 1000 * run.felt().tip_m.z()));
  }
  figure("force beside the spring's while pressing deeper, N", most_N, "1e-3");
  EXPECT_LT(most_N, 1e-3);
}

TEST(Brake, RaisesFrictionOnContact) {
  for (const double own : {0.0, 0.2}) {
    for (const double brake : {0.0, 0.5}) {
      const SceneImage image =
          surface_scene("\"stiffness_N_m\": 1000, \"friction_mode\": \"steady\", \"static_friction\": " +
                        std::to_string(own) + ", \"brake_friction\": " + std::to_string(brake));
      IdealRun run(image);
      run.restart({0, 0, 0.001});
      run.move({0.02, 0, 0.001}, 2.5e-5);
      EXPECT_EQ(run.felt().force_N.norm(), 0.0);  // no brake in the air
      run.move({0.02, 0, -0.002}, 2.5e-5);
      run.move({0.04, 0, -0.002}, 2.5e-5);
      const double ratio = -run.felt().force_N.x() / run.felt().force_N.z();
      figure("brake " + std::to_string(brake) + " on friction " + std::to_string(own) + ": F_t / F_n", ratio,
             std::to_string(own + brake));
      EXPECT_NEAR(ratio, own + brake, 1e-3);
    }
  }
}

}  // namespace
}  // namespace thimble::test
