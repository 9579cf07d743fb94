#include "host-tools/commission/turns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr double kAliveCounts = 20;   // fewer are no motion
constexpr double kReturnCounts = 3;   // to the same stop
constexpr double kReturnPart = 2e-4;  // of the way: a fine encoder sees how hard the hand pulls into the stop
constexpr double kSpanTolerance = .03;   // of the way between the stops
constexpr double kStopTolerance = .065;  // up to here the stops are elsewhere, beyond it the ratio is wrong
constexpr double kOwnByOther = 10;       // own counts by any other's, both as parts of their ways

struct Extremes {
  std::vector<std::size_t> lows, highs;  // ticks
};

// Turning points of a counter, with a hysteresis of half its way.
Extremes turning_points(const BenchRecording& recording, std::size_t axis, double way) {
  Extremes found;
  const auto value = [&](std::size_t k) { return recording.ticks[k].counts.at(axis); };
  std::size_t high = 0, low = 0;
  int direction = 0;
  for (std::size_t k = 0; k < recording.ticks.size(); ++k) {
    if (value(k) > value(high)) high = k;
    if (value(k) < value(low)) low = k;
    const bool fell = static_cast<double>(value(high) - value(k)) > way / 2;
    const bool rose = static_cast<double>(value(k) - value(low)) > way / 2;
    if (direction >= 0 && fell) {
      if (direction > 0) found.highs.push_back(high);
      direction = -1;
      low = k;
    } else if (direction <= 0 && rose) {
      if (direction < 0) found.lows.push_back(low);
      direction = 1;
      high = k;
    }
  }
  if (direction > 0) found.highs.push_back(high);
  if (direction < 0) found.lows.push_back(low);
  return found;
}

PerAxis<double> mean_place(const BenchRecording& recording, const std::vector<std::size_t>& ticks,
                           std::size_t axes) {
  PerAxis<double> mean{};
  for (const std::size_t tick : ticks)
    for (std::size_t j = 0; j < axes; ++j)
      mean.at(j) +=
          static_cast<double>(recording.ticks[tick].counts.at(j)) / static_cast<double>(ticks.size());
  return mean;
}

double spread_of(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto [low, high] = std::ranges::minmax(values);
  return high - low;
}

double expected_way(const Expectation& arm, std::size_t axis) {
  const Expectation::Span span = arm.span(axis, arm.home());
  return std::abs(arm.counts(axis, span.upper - span.lower));
}

// Which counter moved when a joint was turned; -1: none.
int counter_of(const Expectation& arm, const Turn& turn) {
  int seen = -1;
  double most = 0;
  for (std::size_t k = 0; k < arm.axes(); ++k) {
    const double part = turn.counter.at(k).way() / expected_way(arm, k);
    if (turn.counter.at(k).way() < kAliveCounts || part <= std::max(most, .1)) continue;
    most = part;
    seen = static_cast<int>(k);
  }
  return seen;
}

ArmFinding swapped(const Expectation& arm, std::size_t j, std::size_t k) {
  ArmFinding found =
      finding(arm, ArmFault::kEncodersSwapped, j,
              fmt::format("the counter of {} moved when {} was turned", quoted(arm, k), quoted(arm, j)));
  found.other = static_cast<int>(k);
  found.twins = {ArmFault::kJointsSwapped};
  found.text += " Step 5 tells whether their motors are exchanged, too.";
  found.corrections = {
      {fmt::format("/axes/{}/encoder/port", j), static_cast<double>(arm.axis(k).encoder.port)},
      {fmt::format("/axes/{}/encoder/port", k), static_cast<double>(arm.axis(j).encoder.port)}};
  return found;
}

// Three or more encoders in a ring: one finding, which puts all of them right. The exchange of each pair for itself would not.
ArmFinding turned_round(const Expectation& arm, std::size_t first, const std::vector<int>& seen) {
  ArmFinding found = swapped(arm, first, static_cast<std::size_t>(seen[first]));
  found.corrections.clear();
  std::string way = quoted(arm, first);
  for (std::size_t j = first;;) {
    const auto k = static_cast<std::size_t>(seen[j]);
    found.corrections.push_back(
        {fmt::format("/axes/{}/encoder/port", j), static_cast<double>(arm.axis(k).encoder.port)});
    fmt::format_to(std::back_inserter(way), ", {}", quoted(arm, k));
    j = k;
    if (j == first) break;
  }
  found.text += fmt::format(
      " The plugs go round: the encoder of each of {} is where that of the next one belongs.", way);
  return found;
}

// How many axes the exchange goes through, from `first` back to it; 0: it does not come back.
std::size_t ring_of(const std::vector<int>& seen, std::size_t first) {
  std::size_t at = first;
  for (std::size_t count = 1; count <= seen.size(); ++count) {
    if (seen[at] < 0) return 0;
    at = static_cast<std::size_t>(seen[at]);
    if (at == first) return count;
  }
  return 0;
}

bool is_first_of_ring(const std::vector<int>& seen, std::size_t axis) {
  for (auto at = static_cast<std::size_t>(seen[axis]); at != axis; at = static_cast<std::size_t>(seen[at]))
    if (at < axis) return false;
  return true;
}

// None of the counters moved: the one that is nobody else's toggles, or is still.
ArmFinding dead(const Expectation& arm, const Turn& turn, std::size_t j, const std::vector<int>& seen) {
  for (std::size_t k = 0; k < arm.axes(); ++k) {
    if (std::ranges::find(seen, static_cast<int>(k)) != seen.end()) continue;
    const CounterTurn& counter = turn.counter.at(k);
    if (counter.changes >= 10 && counter.way() <= 2)
      return finding(
          arm, ArmFault::kDeadChannel, j,
          fmt::format("{:.0f} counts between the stops, and {} changes", counter.way(), counter.changes));
  }
  return finding(arm, ArmFault::kDeadEncoder, j, "no counts between the stops");
}

void judge_way(const Expectation& arm, const Turn& turn, std::size_t j, std::vector<ArmFinding>& findings) {
  const double factor = turn.counter.at(j).way() / expected_way(arm, j);
  if (std::abs(factor - 1) <= kSpanTolerance) return;
  const std::string figures = fmt::format("{:.0f} counts between the stops, {:.0f} expected: {:.3f} times",
                                          turn.counter.at(j).way(), expected_way(arm, j), factor);
  const ArmEncoder& encoder = arm.axis(j).encoder;
  for (const double power : {.25, .5, 2.0, 4.0}) {
    if (std::abs(factor / power - 1) > kSpanTolerance) continue;
    ArmFinding found = finding(arm, ArmFault::kWrongCounts, j, figures, power);
    found.twins = {ArmFault::kWrongRatio};
    found.text += " A ratio that is off by the same factor looks the same; step 5 tells them apart.";
    found.corrections = {
        {fmt::format("/axes/{}/encoder/counts_per_turn", j), encoder.counts_per_turn.value * power}};
    findings.push_back(found);
    return;
  }
  if (std::abs(factor - 1) <= kStopTolerance) {
    findings.push_back(finding(arm, ArmFault::kStopElsewhere, j, figures, factor));
    return;
  }
  ArmFinding found = finding(arm, ArmFault::kWrongRatio, j, figures, factor);
  found.twins = {ArmFault::kStopElsewhere, ArmFault::kWrongCounts};
  const double turns = encoder.turns_per_turn.value;
  found.corrections = {{fmt::format("/axes/{}/encoder/turns_per_turn", j), turns * factor}};
  if (arm.driven(j) && arm.axis(j).drive->turns_per_turn.value == turns)
    found.corrections.push_back({fmt::format("/axes/{}/drive/turns_per_turn", j), turns * factor});
  findings.push_back(found);
}

void judge_own(const Expectation& arm, const Turn& turn, std::size_t j, std::vector<ArmFinding>& findings,
               std::vector<std::string>& notes) {
  const CounterTurn& own = turn.counter.at(j);
  const int expected = arm.axis(j).per_count() > 0 ? 1 : -1;
  if (own.first == -expected && turn.first_against == expected) {
    ArmFinding found = finding(
        arm, ArmFault::kEncoderSign, j,
        fmt::format("it counted {} when it was turned as asked, both times", own.first > 0 ? "up" : "down"));
    found.corrections = {{fmt::format("/axes/{}/encoder/sign", j), -arm.axis(j).encoder.sign}};
    findings.push_back(found);
  } else if (own.first != expected || turn.first_against != -expected) {
    notes.push_back(quoted(arm, j) +
                    " was turned in different directions in its two trials: repeat the step.");
    findings.push_back(finding(arm, ArmFault::kEncoderSign, j, "the two trials do not agree"));
  }
  // Where the encoder has more counts than the file says, the hand's error has more, too.
  const double allowed =
      std::max(kReturnCounts * std::max(1.0, own.way() / expected_way(arm, j)), kReturnPart * own.way());
  if (own.return_error() > allowed)  // it has part in the way between the stops, too
    findings.push_back(finding(arm, ArmFault::kSlip, j,
                               fmt::format("the same stop was {:.0f} counts apart", own.return_error())));
  else
    judge_way(arm, turn, j, findings);
}

}  // namespace

double CounterTurn::return_error() const { return std::max(spread_of(lows), spread_of(highs)); }

Turn read_turn(const BenchRecording& recording, std::size_t own, std::size_t axes) {
  Turn turn;
  if (recording.ticks.empty())
    throw Error(ExitCode::kLinkLost, "nothing-recorded",
                "the bench recorded nothing while the axis was turned", "do the step again");
  turn.illegal = recording.illegal;
  for (std::size_t j = 0; j < axes; ++j) {
    CounterTurn& counter = turn.counter.at(j);
    const std::int64_t start = recording.ticks.front().counts.at(j);
    counter.low = counter.high = start;
    std::int64_t last = start;
    for (const BenchTick& tick : recording.ticks) {
      const std::int64_t now = tick.counts.at(j);
      counter.low = std::min(counter.low, now);
      counter.high = std::max(counter.high, now);
      if (now != last) ++counter.changes;
      last = now;
    }
    for (const BenchTick& tick : recording.ticks) {
      const auto moved = static_cast<double>(tick.counts.at(j) - start);
      if (std::abs(moved) < .2 * counter.way() || counter.way() < kAliveCounts) continue;
      counter.first = moved > 0 ? 1 : -1;
      break;
    }
    if (counter.way() < kAliveCounts) continue;
    const Extremes ends = turning_points(recording, j, counter.way());
    for (const std::size_t tick : ends.lows)
      counter.lows.push_back(static_cast<double>(recording.ticks[tick].counts.at(j)));
    for (const std::size_t tick : ends.highs)
      counter.highs.push_back(static_cast<double>(recording.ticks[tick].counts.at(j)));
    if (j != own) continue;
    turn.low_place = mean_place(recording, ends.lows, axes);
    turn.high_place = mean_place(recording, ends.highs, axes);
  }
  return turn;
}

std::vector<ArmFinding> judge_turns(const Expectation& arm, const std::vector<Turn>& turns,
                                    std::vector<std::string>& notes) {
  std::vector<ArmFinding> findings;
  std::vector<int> seen;
  seen.reserve(turns.size());
  for (const Turn& turn : turns) seen.push_back(counter_of(arm, turn));
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    if (turns[j].illegal.at(j) > 0)
      findings.push_back(finding(
          arm, ArmFault::kNoise, j,
          fmt::format("{} transitions that no encoder makes while it was turned", turns[j].illegal.at(j))));
    if (seen[j] < 0) {
      const bool exchanged = std::ranges::find(seen, static_cast<int>(j)) != seen.end();
      findings.push_back(dead(arm, turns[j], j, seen));
      if (exchanged)
        findings.back().text += " Its counter moved with another joint: the plugs are exchanged, too.";
      continue;
    }
    const auto k = static_cast<std::size_t>(seen[j]);
    if (k != j) {
      if (ring_of(seen, j) > 2) {
        if (is_first_of_ring(seen, j)) findings.push_back(turned_round(arm, j, seen));
        continue;
      }
      // Once for each pair.
      if (j < k || seen[k] != static_cast<int>(j)) findings.push_back(swapped(arm, j, k));
      continue;
    }
    judge_own(arm, turns[j], j, findings, notes);
    for (std::size_t other = 0; other < arm.axes(); ++other) {
      const double part = turns[j].counter.at(other).way() / expected_way(arm, other);
      const double own = turns[j].counter.at(j).way() / expected_way(arm, j);
      if (other != j && part * kOwnByOther > own)
        notes.push_back(
            fmt::format("{} moved, too, while {} was turned: hold it still, or its coupling differs.",
                        quoted(arm, other), quoted(arm, j)));
    }
  }
  return findings;
}

PerAxis<double> place_of_stops(const Expectation& arm, const std::vector<Turn>& turns) {
  constexpr int kRounds = 60;
  PerAxis<double> at_zero{};
  const auto axes = arm.axes();
  // Begin with the others at home; a limit of a sum of axes depends on where they are.
  const auto place = [&](const PerAxis<double>& counts) {
    board::JointVector at(static_cast<Eigen::Index>(axes));
    for (std::size_t k = 0; k < axes; ++k)
      at[static_cast<Eigen::Index>(k)] = at_zero.at(k) + counts.at(k) * arm.axis(k).per_count();
    return at;
  };
  for (int round = 0; round < kRounds; ++round) {
    PerAxis<double> next{};
    for (std::size_t j = 0; j < axes; ++j) {
      const bool up = arm.axis(j).per_count() > 0;
      const PerAxis<double>& lower = up ? turns[j].low_place : turns[j].high_place;
      const PerAxis<double>& upper = up ? turns[j].high_place : turns[j].low_place;
      const board::JointVector low_others = round == 0 ? arm.home() : place(lower);
      const board::JointVector high_others = round == 0 ? arm.home() : place(upper);
      const double middle = .5 * (arm.span(j, low_others).lower + arm.span(j, high_others).upper);
      next.at(j) = middle - .5 * (lower.at(j) + upper.at(j)) * arm.axis(j).per_count();
    }
    at_zero = next;
  }
  return at_zero;
}

}  // namespace thimble::host
