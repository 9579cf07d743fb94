#include "host-tools/commission/pulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host-tools/commission/balance.h"
#include "host-tools/commission/estimate.h"

namespace thimble::host {
namespace {

constexpr double kCoast_s = .15;
constexpr double kMostBeside_rad = .1;  // of a place of the series from the balanced one
// The same for the motor: a dead phase leaves it without torque twice in an electrical turn. To both sides this is all of the way from one such place to
// the next for 6 pole pairs, and three quarters of it for 4.
constexpr double kMostMotor_rad = .3;
// Places of a series, as parts of the way beside the balanced one: irregular, so that no number of poles is met at equal angles.
constexpr std::array kPlaces{0.0, .13, -.31, .47, -.62, .72, -.88, 1.0};

constexpr std::size_t kLeastEdges = 3;

// When a counter changed, and its count halfway: known to a tick, where a count alone is known to one.
struct Edge {
  double time_s, counts;
};
std::vector<Edge> edges_of(const BenchRecording& recording, std::size_t axis, std::size_t from,
                           std::size_t to, double start) {
  std::vector<Edge> edges;
  double last = start;
  for (std::size_t k = from; k < to; ++k) {
    const auto now = static_cast<double>(recording.ticks[k].counts.at(axis));
    const double tick_s =
        k == 0 ? recording.ticks[0].time_s : recording.ticks[k].time_s - recording.ticks[k - 1].time_s;
    if (now != last) edges.push_back({recording.ticks[k].time_s - .5 * tick_s, .5 * (now + last)});
    last = now;
  }
  return edges;
}

// c of counts = offset + speed (t - from) + c (t - from)^2, by least squares, with the speed known.
double fitted_square(const std::vector<Edge>& edges, double from_s, double speed) {
  double n = 0, sum_s = 0, sum_x = 0, sum_ss = 0, sum_sx = 0;
  for (const Edge& edge : edges) {
    const double t = edge.time_s - from_s, square = t * t, x = edge.counts - speed * t;
    n += 1;
    sum_s += square;
    sum_x += x;
    sum_ss += square * square;
    sum_sx += square * x;
  }
  return (n * sum_sx - sum_s * sum_x) / (n * sum_ss - sum_s * sum_s);
}

// So much that the pulse ends after most of its time at the largest speed; by friction and peak alone where the inertia is not known.
double pulse_current_A(const Expectation& arm, std::size_t axis) {
  constexpr double kPart = .8;
  return current_to_end_A(arm, axis, kPart * kPulse_s);
}

// So far beside the balanced place that a motor without gear turns, too; within the stops, where the weight still is less than half of the friction.
double way_beside(const Expectation& arm, std::size_t axis, const board::JointVector& at) {
  const ArmAxis& own = arm.axis(axis);
  const double friction = own.friction.coulomb_N_m.value;
  double way = std::max((arm.knows_inertia() ? 1 : .6) * kMostBeside_rad * per_radian(own),
                        kMostMotor_rad * own.motor->torque_constant_N_m_A.value / std::abs(own.per_ampere()));
  const Expectation::Span span = arm.span(axis, at);
  const double spread = std::min(kLeastSpread, arm.spread(at));
  const auto row = static_cast<Eigen::Index>(axis);
  for (int k = 0; k < 16 && way > .01 * per_radian(own); ++k) {
    bool fits = true;
    for (const double sign : {-1.0, 1.0}) {
      board::JointVector there = at;
      there[row] += sign * way;
      fits &= there[row] >= span.lower && there[row] <= span.upper && arm.spread(there) >= spread &&
              (friction <= 0 || arm.turning(axis, there) < .5 * friction);
    }
    if (fits) break;
    way *= .75;
  }
  return way;
}

}  // namespace

double current_to_end_A(const Expectation& arm, std::size_t axis, double seconds) {
  constexpr double kPeakShare = .02, kFriction = 3;
  const double friction = arm.axis(axis).friction.coulomb_N_m.value;
  double wanted_N_m = std::max(kFriction * friction, kPeakShare * arm.axis(axis).peak_torque());
  if (arm.knows_inertia()) {
    const auto row = static_cast<Eigen::Index>(axis);
    const double speed = gentle_ends(arm).counts_s.at(axis) * std::abs(arm.axis(axis).per_count());
    wanted_N_m = 1.1 * friction + arm.mass(arm.balanced(axis))(row, row) * speed / seconds;
  }
  return std::min(gentle_current_A(arm, axis), wanted_N_m / std::abs(arm.axis(axis).per_ampere()));
}

PulseSeen pulse(StepContext& context, std::size_t drive, std::size_t loose, double current_A,
                double seconds) {
  const BenchFacts facts = context.bench.facts();
  AxisProgram program;
  program.axis = drive;
  program.seconds = seconds;
  program.constant_A = current_A;
  program.coast_s = kCoast_s;
  program.ends = gentle_ends(context.arm);
  demand_gentle(context.arm, program);
  const PerAxis<AxisReading> before = context.bench.read();
  const BenchRecording seen = context.bench.run(program);
  PulseSeen pulse;
  pulse.asked_A = current_A;
  if (seen.driven_ticks == 0 || seen.ticks.empty()) return pulse;
  const double per_count = context.arm.axis(loose).per_count();
  const auto start = static_cast<double>(before.at(loose).counts);
  const auto end = static_cast<double>(seen.ticks[seen.driven_ticks - 1].counts.at(loose));
  pulse.way = (end - start) * per_count;
  pulse.way_counts = std::abs(end - start);
  pulse.moved = pulse.way_counts >= kPulseCounts;
  const double driven_s = static_cast<double>(seen.driven_ticks) * facts.tick_s;
  // With x in the pulse and y after it: v = 2 x / t, and what brakes is v^2 / 2y = (2 x / t^2) (x / y). The sum is torque by inertia.
  pulse.early = seen.ending != Ending::kTime;
  const std::vector<Edge> driven = edges_of(seen, loose, 0, seen.driven_ticks, start);
  const std::vector<Edge> coasting = edges_of(seen, loose, seen.driven_ticks, seen.ticks.size(), end);
  if (pulse.moved && driven.size() >= kLeastEdges && coasting.size() >= kLeastEdges) {
    // The offset takes what the motor goes ahead of the joint by the stretch of the transmission.
    const double forward = fitted_square(driven, 0, 0);
    const double braking = fitted_square(coasting, driven_s, 2 * forward * driven_s);
    pulse.acceleration = 2 * (forward - braking) * per_count;
    pulse.clean = pulse.acceleration * pulse.way > 0;
  }
  std::vector<double> currents, voltages;  // that were measured in the last half
  for (std::size_t k = seen.driven_ticks / 2; k < seen.driven_ticks; ++k) {
    const BenchTick& tick = seen.ticks[k];
    if (!std::isnan(tick.current_A.at(drive))) currents.push_back(tick.current_A.at(drive));
    if (!std::isnan(tick.voltage_V.at(drive))) voltages.push_back(tick.voltage_V.at(drive));
  }
  pulse.current_A = currents.empty() ? kNotMeasured : mean(currents);
  // The axis moves where its torque pushes it, whatever the signs in the file are.
  const double speed = 1.5 * std::abs(pulse.way) / driven_s;  // about, over the last half
  const double emf_V = drive == loose ? std::abs(context.arm.axis(drive).per_ampere()) * speed : 0;
  pulse.voltage_V = (voltages.empty() ? kNotMeasured : mean(voltages)) - std::copysign(emf_V, current_A);
  return pulse;
}

std::size_t PulseSeries::moving() const {
  std::size_t count = 0;
  for (std::size_t k = 0; k < up.size(); ++k)
    if (up[k].moved || down[k].moved) ++count;
  return count;
}

PulseSeries pulse_series(StepContext& context, std::size_t axis) {
  const Expectation& arm = context.arm;
  PulseSeries series;
  const board::JointVector balanced = resting_place(context, axis);
  const double beside = way_beside(arm, axis, balanced);
  const double current_A = pulse_current_A(arm, axis);
  double share = 1;  // of the current; as little as shows the motion well
  for (const double part : kPlaces) {
    board::JointVector at = balanced;
    at[static_cast<Eigen::Index>(axis)] += part * beside;
    std::array<PulseSeen, 2> both;
    for (std::size_t k = 0; k < 2; ++k) {
      if (place(context, axis, at) == Answer::kStop) return series;
      both[k] = pulse(context, axis, axis, (k == 0 ? share : -share) * current_A, kPulse_s);
      for (int tries = 0;
           part == 0.0 && tries < 6 && both[k].way_counts < (both[k].early ? 1 : 2) * kPulseCounts; ++tries) {
        const double most = gentle_current_A(arm, axis) / current_A;
        if (both[k].early ? share < .5 : share >= most) break;
        share = both[k].early ? .85 * share : std::min(most, 1.3 * share);
        if (place(context, axis, at) == Answer::kStop) return series;
        both[k] = pulse(context, axis, axis, (k == 0 ? share : -share) * current_A, kPulse_s);
      }
    }
    // As at the balanced place.
    const double heavier = arm.inertia(axis, at) / arm.inertia(axis, balanced);
    for (PulseSeen& seen : both) seen.acceleration *= heavier;
    series.up.push_back(both[0]);
    series.down.push_back(both[1]);
  }
  return series;
}

double answer_of(const std::vector<PulseSeen>& pulses) {
  std::vector<double> values;
  values.reserve(pulses.size());
  for (const PulseSeen& seen : pulses)
    if (seen.clean) values.push_back(seen.acceleration / seen.asked_A);
  return median(std::move(values));
}

}  // namespace thimble::host
