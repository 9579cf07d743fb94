// The stiffest wall that an arm holds, from the numbers of its file: a simulated hand presses the simulated arm on a wall, as docs/stability.md has it for
// the arms that come with Thimble. The file's friction, inertia, stiffness, counts and delay are what limits it, so measured ones give the limit
// of this arm. At 1 kHz it is within 15 % of what the firmware holds on the simulated arms; at 4 kHz it is 24 to 35 % below (wall_limit_test with
// 4000 beside 1000 prints it), so it is not to be told to a builder yet.
#pragma once

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
};

// Swing of the tip across the wall in the last half of the hold, peak to peak; the plant moves, the controller goes by the file.
[[nodiscard]] double wall_swing_m(const ArmFile& file, const board::AnyPlantParameters& plant,
                                  double stiffness_N_m, const WallTrial& trial);
// Two counts at the tip along the wall's normal: more is a swing.
[[nodiscard]] double wall_tolerance_m(const ArmFile& file);
// The largest stiffness, N/m, up to which every wall, in steps of a fifth from 100 N/m, is still; to 3 %. 0: even that swings.
[[nodiscard]] double largest_wall_N_m(const ArmFile& file, const board::AnyPlantParameters& plant,
                                      const WallTrial& trial);

}  // namespace thimble::host
