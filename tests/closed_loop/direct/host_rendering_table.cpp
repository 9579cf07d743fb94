// Prints the table of docs/host-rendering.md: the stiffest stable wall, rendered by a host and on the board,
// for several delays of the link.
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "tests/closed_loop/direct/linked_wall.h"

namespace thimble::test {
namespace {

void print(float stiffness_N_m) {
  const double unit = std::pow(10.0, std::floor(std::log10(static_cast<double>(stiffness_N_m) + 1)) - 1);
  if (stiffness_N_m == 0)
    std::printf(" none |");
  else
    std::printf(" %.0f |", std::floor(static_cast<double>(stiffness_N_m) / unit) * unit);  // two digits
  std::fflush(stdout);
}

void table() {
  constexpr float kSoftest_N_m = 50, kStep = 1.2F;
  constexpr int kHalvings = 4;
  const board::Hand hand, finger{.01, 100, 1};
  std::printf(
      "| link, each way | host, hand of 50 g | board, hand of 50 g | host, light finger | board, light "
      "finger |\n"
      "|---|---|---|---|---|\n");
  for (const double delay_s : {0.0, .0005, .001, .002, .005, .010}) {
    std::printf("| %g ms |", 1e3 * delay_s);
    for (const board::Hand& holder : {hand, finger}) {
      for (const bool on_host : {true, false}) {
        const LinkedWall wall{.on_host = on_host, .delay_s = delay_s, .hand = holder};
        print(largest_stiffness(wall, still, kSoftest_N_m, kStep, kHalvings));
      }
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace thimble::test

int main() {
  thimble::test::table();
  return 0;
}
