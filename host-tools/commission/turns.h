// What the counters saw while one joint was turned by hand from stop to stop, and which fault that shows.
#pragma once

#include <vector>

#include "host-tools/commission/steps.h"

namespace thimble::host {

struct CounterTurn {
  std::int64_t low = 0, high = 0;   // of all counts
  std::vector<double> lows, highs;  // at the turning points
  int first = 0;                    // direction of the first motion; 0: none
  int changes = 0;                  // ticks in which it changed
  [[nodiscard]] double way() const { return static_cast<double>(high - low); }
  [[nodiscard]] double return_error() const;  // of the turning points at one stop, in counts
};

// `turned` one joint at a time, the axes in their order.
struct Turn {
  PerAxis<CounterTurn> counter{};
  PerAxis<std::uint64_t> illegal{};
  int first_against = 0;  // its own counter's first direction when asked for the other way
  PerAxis<double> low_place{}, high_place{};  // mean counts of all axes while its own is at a stop
};

// Throws Error (kLinkLost, "nothing-recorded") for a recording without ticks.
[[nodiscard]] Turn read_turn(const BenchRecording& recording, std::size_t own, std::size_t axes);
// signs: of the told direction by the file.
[[nodiscard]] std::vector<ArmFinding> judge_turns(const Expectation& arm, const std::vector<Turn>& turns,
                                                  std::vector<std::string>& notes);
// Angle of each axis where its counter is 0, from the stops.
[[nodiscard]] PerAxis<double> place_of_stops(const Expectation& arm, const std::vector<Turn>& turns);

}  // namespace thimble::host
