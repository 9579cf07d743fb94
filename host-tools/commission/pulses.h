// Pulses of one motor while the other joints are held: how an axis answers, and which drive turns which joint.
#pragma once

#include <optional>
#include <vector>

#include "host-tools/commission/steps.h"

namespace thimble::host {

struct PulseSeen {
  double asked_A = 0;
  double way = 0;         // of the axis that was let go, at the end of the pulse: rad or m by the file
  double way_counts = 0;  // the same in counts, without sign
  double acceleration =
      0;  // (torque) / (inertia) without friction and weight, from pulse and coasting; signed as the way
  double current_A = 0;  // measured, over the last half of the pulse; NaN: not measured
  double voltage_V = 0;  // less the back-EMF by the file's torque constant
  bool moved = false;    // by kPulseCounts
  bool clean = false;    // and it coasted, so that the acceleration is known
  bool early = false;    // it ended before its time
};
inline constexpr double kPulseCounts = 5;

// With which the axis is at the speed of gentle_ends() after so long, by the inertia of the file; by friction and peak alone where that is not known.
// At most gentle_current_A().
[[nodiscard]] double current_to_end_A(const Expectation& arm, std::size_t axis, double seconds);

// `drive` pulses, `loose` is the axis that may move.
[[nodiscard]] PulseSeen pulse(StepContext& context, std::size_t drive, std::size_t loose, double current_A,
                              double seconds);

// What an axis did at several places of its motor's turn.
struct PulseSeries {
  std::vector<PulseSeen> up, down;  // by the sign of the current
  [[nodiscard]] std::size_t places() const { return up.size(); }
  [[nodiscard]] std::size_t moving() const;
};
[[nodiscard]] PulseSeries pulse_series(StepContext& context, std::size_t axis);

// Median of acceleration by current, rad/s2/A; signed: positive where a positive current moves the axis as the file says.
[[nodiscard]] double answer_of(const std::vector<PulseSeen>& pulses);

}  // namespace thimble::host
