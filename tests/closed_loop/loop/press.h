// A hand presses the simulated Premium against a wall. Used by the stability tests and the table of
// docs/stability.md.
#pragma once

#include <optional>
#include <string>

#include "board/sim/plant.h"
#include "kinematics/arm_data.h"

namespace thimble::test {

struct Press {
  std::string arm = "premium-1.5";
  std::optional<kinematics::ArmData> arm_data{};  // another arm in its place, on the plant of any family
  double rate_Hz = 4000;
  float stiffness_N_m = 1000;
  float damping_N_s_m = 2;
  double force_N = 2;        // that the hand settles at
  double approach_m_s = .1;  // at which it meets the wall
  double hold_s = 1;
  board::Hand hand{};
};

struct PressResult {
  bool faulted = false;
  double mean_force_N = 0;   // over the last half of the hold, like all below
  double force_swing_N = 0;  // peak to peak, as asked for
  double tip_swing_m = 0;    // peak to peak, across the wall
  double tip_speed_rms_m_s = 0;
};

// Floor under the tip, 10 mm below home. Throws std::runtime_error if the arm cannot be armed.
[[nodiscard]] PressResult press(const Press& press);

}  // namespace thimble::test
