// The stiffest wall that the tool computes from an arm's file, against that of the firmware on the simulated arm of docs/stability.md.
#include "host-tools/commission/wall_limit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "tests/closed_loop/loop/press.h"
#include "tests/support/figure.h"

namespace thimble::host {
namespace {

ArmFile wall_arm(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

double largest_of_firmware(const std::string& arm, double most_m, const WallTrial& trial) {
  const auto still = [&](double k) {
    const test::PressResult seen = test::press({.arm = arm,
                                                .rate_Hz = trial.rate_Hz,
                                                .stiffness_N_m = static_cast<float>(k),
                                                .damping_N_s_m = static_cast<float>(trial.damping_N_s_m),
                                                .hold_s = trial.hold_s,
                                                .hand = trial.hand});
    return !seen.faulted && seen.tip_swing_m <= most_m;
  };
  double last = 0, k = 100;
  while (still(k) && k < 1e5) {
    last = k;
    k *= 1.2;
  }
  for (double high = k; high > 1.03 * last;) {
    const double middle = std::sqrt(last * high);
    (still(middle) ? last : high) = middle;
  }
  return last;
}

TEST(WallLimit, IsThatOfTheFirmwareOnTheSimulatedArm) {
  for (const char* name : {"premium-1.5"}) {
    const ArmFile file = wall_arm(name);
    const board::AnyPlantParameters plant = board::AnyPlantParameters::from(arm_data(file));
    for (const double rate_Hz : {1000.0}) {
      const WallTrial trial{.rate_Hz = rate_Hz, .damping_N_s_m = 1};
      const double computed = largest_wall_N_m(file, plant, trial);
      const double found = largest_of_firmware(name, wall_tolerance_m(file), trial);
      test::figure(
          std::string(name) + " at " + std::to_string(static_cast<int>(rate_Hz)) + " Hz, N/m: firmware",
          found, "");
      test::figure("  computed", computed, "15 %");
      EXPECT_NEAR(computed / found, 1, .15);
    }
  }
}

}  // namespace
}  // namespace thimble::host
