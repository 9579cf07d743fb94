#include "host-tools/commission/balance.h"

#include <algorithm>
#include <cmath>

namespace thimble::host {
namespace {

constexpr double kFalls = .05;  // rad, or of the way between the stops where that is less
constexpr double kWait_s = .2;
// Of the way between the stops; so far from one that a fall on it is seen.
constexpr double kFirstStep = .2, kFromStop = .08;
constexpr int kMostTrials = 12;

// 0: it stays; else the direction in which it fell. NaN: the builder stops.
double falls(StepContext& context, std::size_t axis, const board::JointVector& at, double enough,
             double wait_s = kWait_s) {
  if (place(context, axis, at) == Answer::kStop) return std::nan("");
  static_cast<void>(context.bench.wait(wait_s, false));
  PerAxis<std::int64_t> counts{};
  const PerAxis<AxisReading> readings = context.bench.read();
  for (std::size_t j = 0; j < context.arm.axes(); ++j) counts.at(j) = readings.at(j).counts;
  const auto row = static_cast<Eigen::Index>(axis);
  const double moved = angles(context, counts)[row] - at[row];
  return std::abs(moved) < enough ? 0 : std::copysign(1.0, moved);
}

// Between two places from which it falls towards each other, or away.
std::optional<board::JointVector> between(StepContext& context, std::size_t axis, board::JointVector at,
                                          double one, double other, double falls_at_one, double enough) {
  const auto row = static_cast<Eigen::Index>(axis);
  for (int trial = 0; trial < kMostTrials; ++trial) {
    at[row] = .5 * (one + other);
    const double direction = falls(context, axis, at, enough);
    if (direction == 0) return at;
    if (std::isnan(direction)) return std::nullopt;
    (direction == falls_at_one ? one : other) = at[row];
  }
  return std::nullopt;
}

double enough_of(const Expectation::Span& span) {
  return std::min(kFalls, kFalls * (span.upper - span.lower));
}

std::optional<board::JointVector> search(StepContext& context, std::size_t axis,
                                         const board::JointVector& begin) {
  const auto row = static_cast<Eigen::Index>(axis);
  const Expectation::Span span = context.arm.span(axis, begin);
  const double way = span.upper - span.lower, enough = enough_of(span);
  const double first = falls(context, axis, begin, enough);
  if (first == 0) return begin;
  if (std::isnan(first)) return std::nullopt;
  // It hangs below where it falls to, and stands above where it falls from.
  for (const double side : {first, -first}) {
    double last = begin[row];
    for (;;) {
      board::JointVector at = begin;
      at[row] = std::clamp(last + side * kFirstStep * way, span.lower + kFromStop * way,
                           span.upper - kFromStop * way);
      if (std::abs(at[row] - last) < kFromStop * way) break;
      const double direction = falls(context, axis, at, enough);
      if (direction == 0) return at;
      if (std::isnan(direction)) return std::nullopt;
      if (direction != first) return between(context, axis, at, last, at[row], first, enough);
      last = at[row];
    }
  }
  return std::nullopt;
}

}  // namespace

board::JointVector resting_place(StepContext& context, std::size_t axis) {
  board::JointVector begin = context.arm.balanced(axis);
  if (context.arm.knows_inertia() || !context.arm.gravity_turns(axis)) return begin;
  std::optional<board::JointVector>& known = context.known.resting.at(axis);
  if (!known) known = search(context, axis, begin);
  return known.value_or(begin);
}

Rest rest_of(StepContext& context, std::size_t axis) {
  const Expectation& arm = context.arm;
  if (!arm.gravity_turns(axis)) return Rest::kStays;
  const board::JointVector at = resting_place(context, axis);
  // A heavy rotor falls slowly: longer than the search for the place waits.
  constexpr double kSure = .5, kLong_s = .6;
  const double friction = arm.axis(axis).friction.coulomb_N_m.value;
  if (arm.knows_inertia() && arm.turning(axis, at) <= kSure * friction) return Rest::kStays;
  const double direction = falls(context, axis, at, enough_of(arm.span(axis, at)), kLong_s);
  if (std::isnan(direction)) return Rest::kStopped;
  return direction == 0 ? Rest::kStays : Rest::kFalls;
}

}  // namespace thimble::host
