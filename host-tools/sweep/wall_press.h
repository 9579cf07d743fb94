// A hand meets a wall and presses it: the simulation behind docs/stability.md.
#pragma once

#include <optional>
#include <string>

#include "host-tools/sweep/measures.h"

namespace thimble::host {

struct WallPress {
  std::string arm = "premium-1.5";
  std::optional<kinematics::ArmData> arm_data{};  // another arm in its place, on the plant of any family
  double rate_Hz = 4000;
  double stiffness_N_m = 1000;
  double damping_N_s_m = 2;
  double force_N = 2;        // that the hand settles at
  double approach_m_s = .1;  // at which it meets the wall
  double hold_s = 1;         // the last half of it is the steady part
  board::Hand hand{};
  std::uint64_t seed = 1;
};

// A floor under the tip, 10 mm below home; swings are across it. The board's receivers report lost lines of encoders: its probes of encoders at rest
// would be taken for a limit cycle.
[[nodiscard]] MeasuredRun run_of(const WallPress& press);
// Throws std::runtime_error where there is no run; a fault is none of these.
[[nodiscard]] Measured measure(const WallPress& press);

}  // namespace thimble::host
