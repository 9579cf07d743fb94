// One wall rendered in simulated time, either by a host behind a link with a delay or on the board. The
// firmware core runs on the simulated arm; only CAN frames, with the delay of the link in each direction,
// connect it with the host. The host answers every pose with a force, at once. A hand presses the wall as in
// press.h.
//
//   a pose of tick k is sent after it, is at the host `delay` later, and its force acts from tick k + 1 + 2 delay on
#pragma once

#include <string>

#include "board/sim/plant.h"

namespace thimble::test {

struct LinkedWall {
  bool on_host = true;
  double delay_s = 0;  // each way; whole ticks
  float stiffness_N_m = 500;
  std::string arm = "premium-1.5";
  double rate_Hz = 4000;
  unsigned ticks_a_pose = 4;  // 1 kHz
  board::Hand hand{};
  double press_N = 2;        // that the hand settles at
  double approach_m_s = .1;  // at which it meets the wall
  double hold_s = 3;
};

struct LinkedWallResult {
  bool faulted = false;
  double mean_force_N = 0;       // over the last half of the hold
  double tip_swing_m = 0;        // peak to peak, across the wall, over that
  double first_swing_m = 0;      // over the fifth before the last half, and
  double last_swing_m = 0;       // over the last fifth
  std::uint32_t orders = 0;      // that the board had taken at the end
  std::uint32_t expired = 0;     // how often none came in time
  double orders_per_s = 0;       // over the last half
  std::uint32_t wall_ticks = 0;  // of the board's scene: with contact
};

[[nodiscard]] LinkedWallResult press(const LinkedWall& wall);

// The wall is still when the tip swings by no more than two encoder counts over the last half.
[[nodiscard]] bool still(const LinkedWall& wall);
// A swing that is smaller at the end than in the middle dies down: whether a linear loop is stable, without a
// word on what friction and counts make of small ones.
[[nodiscard]] bool dies_down(const LinkedWall& wall);

// The largest stiffness for which `stable` holds, and held for all from `softest_N_m` on in steps by `step`;
// the last step is halved `halvings` times. 0: not even the softest.
template <class Stable>
[[nodiscard]] float largest_stiffness(LinkedWall wall, Stable&& stable, float softest_N_m, float step,
                                      int halvings) {
  constexpr float kStiffest_N_m = 1.0e5F;  // the scene's own limit
  const auto holds = [&](float stiffness_N_m) {
    wall.stiffness_N_m = stiffness_N_m;
    return stable(wall);
  };
  float good = 0, bad = softest_N_m;
  for (; bad <= kStiffest_N_m && holds(bad); bad *= step) good = bad;
  if (good == 0 || bad > kStiffest_N_m) return good;
  for (int i = 0; i < halvings; ++i) {
    const float middle = (good + bad) / 2;
    (holds(middle) ? good : bad) = middle;
  }
  return good;
}

// Of hand and arm together, across the wall, at home: kg. The motors' part is in it.
[[nodiscard]] double moved_mass_kg(const std::string& arm, const board::Hand& hand);

}  // namespace thimble::test
