// The stiffest wall that an arm holds, from the numbers of its file: a simulated hand presses the simulated arm on a wall, as docs/stability.md has it for
// the arms that come with Thimble. The file's friction, inertia, stiffness, counts and delay are what limits it, so measured ones give the limit
// of this arm. The force has the limits that the firmware's has: without them the result was a third too low at 4 kHz. So has it the probes of encoders
// (encoder_frozen): on a stiff wall one count changes a joint's torque by so much that the firmware probes it. wall_limit_test compares it with what the
// firmware holds on simulated arms: within 15 % for three arms (wall_limit.many_arms).
#pragma once

#include <functional>

#include "board/sim/any_plant.h"
#include "host-tools/arms/arm_file.h"

namespace thimble::host {

struct WallTrial {
  double rate_Hz = 4000;
  double damping_N_s_m = 0;  // B of the wall
  double force_N = 2;        // that the hand settles at
  double approach_m_s = .1;
  double hold_s = 3;
  board::Hand hand{};
  // The swing as the encoders tell it, at the motors, as step 10 does: half as much again as two counts is a swing then. Otherwise that of the
  // tip, as docs/stability.md has it. Light rotors swing sooner than the tip.
  bool by_counts = false;
};

// Swing of the tip across the wall in the last half of the hold, peak to peak; the plant moves, the controller goes by the file.
[[nodiscard]] double wall_swing_m(const ArmFile& file, const board::AnyPlantParameters& plant,
                                  double stiffness_N_m, const WallTrial& trial);
// Two counts at the tip along the wall's normal: more is a swing.
[[nodiscard]] double wall_tolerance_m(const ArmFile& file);
// The largest stiffness, N/m, below the first wall of 100 N/m, 103, 106 ... at which the median of five walls, its own and two to each side, swings. A
// single wall may be still by chance among those that swing, and another swing among those that are still. 0: even the softest swings; the stiffest
// that is tried, 98 kN/m, if none swings. swing: of a wall, as a part of what is a swing. Each wall is pressed once at most: those 43 % apart until
// one swings by half of that, then all from a fifth below the one before it.
[[nodiscard]] double largest_still_N_m(const std::function<double(double)>& swing);
[[nodiscard]] double largest_wall_N_m(const ArmFile& file, const board::AnyPlantParameters& plant,
                                      const WallTrial& trial);

}  // namespace thimble::host
