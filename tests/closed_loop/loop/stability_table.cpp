// Writes docs/stability.md: the stiffest wall that holds still on the simulated Premium, by tick rate and
// damping.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/closed_loop/loop/press.h"

namespace thimble::test {
namespace {

constexpr double kTwoCounts_m = 59e-6;
constexpr float kStep = 1.2F;
constexpr float kSoftest_N_m = 100, kStiffest_N_m = 1.0e5F;  // the latter is the scene's own limit

bool still(const Press& p) {
  const PressResult r = press(p);
  return !r.faulted && r.tip_swing_m <= kTwoCounts_m;
}

// Stiffer by a fifth each time, until a wall swings. 0: even the softest does.
float largest_still(Press p) {
  float last = 0;
  for (float k = kSoftest_N_m; k <= kStiffest_N_m; k *= kStep) {
    p.stiffness_N_m = k;
    if (!still(p)) return last;
    last = k;
  }
  return kStiffest_N_m;
}

void table(const char* arm, const board::Hand& hand) {
  std::printf("| B, N s/m | 1 kHz | 4 kHz | 10 kHz |\n|---|---|---|---|\n");
  for (const float damping : {0.0F, 1.0F, 2.0F, 5.0F}) {
    std::printf("| %.0f |", static_cast<double>(damping));
    for (const double rate_Hz : {1000.0, 4000.0, 10000.0}) {
      const float k = largest_still(
          {.arm = arm, .rate_Hz = rate_Hz, .damping_N_s_m = damping, .hold_s = 3, .hand = hand});
      const double unit = std::pow(10.0, std::floor(std::log10(std::max(k, 1.0F))) - 1);  // two digits
      std::printf(k >= kStiffest_N_m ? " >= %.0f |" : " %.0f |",
                  std::floor(static_cast<double>(k) / unit) * unit);
      std::fflush(stdout);
    }
    std::printf("\n");
  }
  std::printf("\n");
}

}  // namespace
}  // namespace thimble::test

int main() {
  using thimble::board::Hand;
  std::printf(
      "# How stiff a wall can be\n\n"
      "Written by `build/release/bin/stability_table > docs/stability.md`, in a minute or two; every run "
      "gives the same\n"
      "figures.\n\n"
      "The firmware core runs on the simulated PHANToM Premium 1.5: rotor inertia, friction, encoder counts, "
      "winding and\n"
      "current loop, and the structure's 3.5 N/mm. A hand meets a wall at 0.1 m/s and then presses it with 2 "
      "N for 3 s.\n"
      "The wall counts as still when the fingertip swings by no more than two encoder counts (59 um) over "
      "the last 1.5 s.\n"
      "Each figure is the largest stiffness K in N/m (two digits) up to which every wall, from 100 N/m in "
      "steps of a\n"
      "fifth, stays still. 4 kHz is the default rate. Beyond the structure's own stiffness a hand feels the "
      "structure\n"
      "rather than the wall.\n\n");
  const struct {
    const char* text;
    Hand hand;
  } hands[] = {{"a hand of 50 g, 500 N/m, 5 N s/m", Hand{}},
               {"a light finger of 10 g, 100 N/m, 1 N s/m", Hand{.01, 100, 1}}};
  for (const auto& h : hands) {
    for (const char* arm : {"premium-1.5", "premium-1.5-frictionless"}) {
      std::printf("## %s, %s\n\n", arm, h.text);
      thimble::test::table(arm, h.hand);
    }
  }
  return 0;
}
