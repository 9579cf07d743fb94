#include "tests/closed_loop/direct/linked_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <string>

#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

struct Loop {
  bool on_host;
  double rate_Hz;  // of the ticks; a host's poses come every fourth
  double link_s;   // each way
  [[nodiscard]] double period_s() const { return (on_host ? 4 : 1) / rate_Hz; }
  // From the sample to the force.
  [[nodiscard]] double delay_s() const { return on_host ? 1 / rate_Hz + 2 * link_s : 0; }
};

// Where a mass m on a spring k and a damper b, pressed to a wall K, neither grows nor dies down. The wall's force comes `delay` after
// the sample and is held for T; the structure s between mass and motors gives way to it at once, so that the next sample but n sees
// the motors shifted by it. To the mass the wall is
//   S = K e^(-i w (T/2 + delay)) / (1 + K/s e^(-i w n T)),   m w^2 = k + Re S,   b w = -Im S
double balance_N_m(double mass_kg, const board::Hand& hand, double structure_N_m, const Loop& loop,
                   double amplifier_s) {
  const double T = loop.period_s(), n = std::max(1.0, std::ceil(loop.delay_s() / T));
  const auto wall = [&](double K, double w) {
    const double late_s = T / 2 + loop.delay_s() + amplifier_s;
    return std::polar(K, -w * late_s) / (1.0 + std::polar(K / structure_N_m, -w * n * T));
  };
  const auto feeds = [&](double K) {  // more than the damper takes
    double w = std::sqrt((hand.stiffness_N_m + K) / mass_kg);
    for (int i = 0; i < 100; ++i)
      w = .5 * (w + std::sqrt((hand.stiffness_N_m + wall(K, w).real()) / mass_kg));
    return -wall(K, w).imag() > hand.damping_N_s_m * w;
  };
  double low = 1, high = structure_N_m / 4;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (feeds(middle) ? high : low) = middle;
  }
  return low;
}

// The bound of Colgate and Schenkel (1997), b > K T / 2, with a delay b > K (T / 2 + delay) (Gil, Sanchez, Hulin, Preusche and
// Hirzinger 2009), is that balance for a stiff arm and w T << 1. This arm gives way by 1 mm for 3.5 N.
TEST(LinkedWall, IsStableAsFarAsTheClosedFormSays) {
  const std::string arm = "premium-1.5-frictionless";
  const board::Hand hand{.05, 100, 1};
  const board::PlantParameters parameters = board::PlantParameters::from(*board::find_plant_variant(arm));
  const auto structure_N_m = static_cast<double>(parameters.model.tip_stiffness_N_m);
  for (const Loop& loop : {Loop{true, 4000, .001}, {true, 4000, .002}, {true, 4000, .005}, {false, 100, 0}}) {
    if (kUnderSanitizers && loop.on_host && loop.link_s != .002) continue;
    const double bound_N_m = hand.damping_N_s_m / (loop.period_s() / 2 + loop.delay_s());
    const double balance = balance_N_m(moved_mass_kg(arm, hand), hand, structure_N_m, loop,
                                       parameters.amplifier_time_constant_s);
    const LinkedWall wall{.on_host = loop.on_host,
                          .delay_s = loop.link_s,
                          .arm = arm,
                          .rate_Hz = loop.rate_Hz,
                          .hand = hand,
                          .press_N = 1,
                          .hold_s = 5};
    const auto found =
        static_cast<double>(largest_stiffness(wall, dies_down, static_cast<float>(.6 * balance), 1.15F, 4));
    char what[100];
    (void)std::snprintf(what, sizeof(what), "%s, %.0f ms each way, b / (T/2 + delay) = %.0f: stable to, N/m",
                        loop.on_host ? "host at 1 kHz" : "board at 100 Hz", 1e3 * loop.link_s, bound_N_m);
    figure(what, found, std::to_string(balance) + " +- 3 %");
    EXPECT_NEAR(found, balance, .03 * balance) << what;
    EXPECT_NEAR(found, bound_N_m, .3 * bound_N_m)
        << what << ": the bound itself, the arm's structure left out";
  }
}

// The table of docs/host-rendering.md, coarsely: its light finger.
TEST(LinkedWall, OnTheBoardTheDelayIsNothingToItAndOnTheHostItCosts) {
  float board_N_m = 0, last_N_m = 1e9F;
  for (const double delay_s : {0.0, .001, .005}) {
    LinkedWall wall{.on_host = false, .delay_s = delay_s, .hand = {.01, 100, 1}, .hold_s = 2};
    const float board = largest_stiffness(wall, still, 1000, 1.5F, 0);
    wall.on_host = true;
    const float host = largest_stiffness(wall, still, 50, 1.5F, 0);
    std::printf("%g ms each way: on the board %.0f N/m, on the host %.0f N/m\n", 1e3 * delay_s,
                static_cast<double>(board), static_cast<double>(host));
    if (delay_s == 0) board_N_m = board;
    EXPECT_EQ(board, board_N_m);
    EXPECT_LT(host, last_N_m);
    EXPECT_LT(host, board);
    EXPECT_GT(host, 0.0F);
    last_N_m = host;
  }
}

TEST(LinkedWall, AHostOfOneKilohertzIsHeardAThousandTimesASecond) {
  const LinkedWallResult r = press({.delay_s = .001, .stiffness_N_m = 400});
  figure("orders a second of simulated time", r.orders_per_s, "1000");
  figure("ticks in which none was in time", r.expired, "0");
  figure("mean force of a press of 2 N", r.mean_force_N, "2 +- 0.1");
  EXPECT_NEAR(r.orders_per_s, 1000, 1);
  EXPECT_EQ(r.expired, 0U);
  EXPECT_EQ(r.wall_ticks, 0U) << "the board renders nothing";
  EXPECT_NEAR(r.mean_force_N, 2, .1);
}

}  // namespace
}  // namespace thimble::test
