// Steps 2 and 3: what the builder's hand shows.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-tools/commission/estimate.h"
#include "host-tools/commission/turns.h"

namespace thimble::host {
namespace {

Prompt turn_prompt(const Expectation& arm, std::size_t axis, int times, bool against) {
  const Eigen::Vector3d direction = (against ? -1.0 : 1.0) * arm.direction(axis);
  const std::string first = direction.norm() > 0
                                ? "so that the tip moves " + towards(direction)
                                : std::string("in its ") + (against ? "negative" : "positive") + " direction";
  Prompt asked = prompt(
      Prompt::Kind::kTurn, axis,
      fmt::format("Hold the other joints still, {} in the middle. Turn it by hand from stop to stop, {} "
                  "there and back, first {}.",
                  quoted(arm, axis), times == 1 ? "once" : fmt::format("{} times", times), first));
  asked.direction = direction;
  asked.sign = against ? -1 : 1;
  asked.times = times;
  return asked;
}

struct Passes {
  std::vector<double> forward, backward;  // counts
};

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return high - low;
}

void judge_mark(const StepContext& context, std::size_t j, const Passes& passes, StepResult& result) {
  constexpr double kRepeatCounts = 2, kBothWays = .01, kElsewhere = .3;
  const Expectation& arm = context.arm;
  const ArmEncoder& encoder = arm.axis(j).encoder;
  const double repeat = std::max(range_of(passes.forward), range_of(passes.backward));
  if (repeat > kRepeatCounts) {
    ArmFinding found =
        finding(arm, ArmFault::kSlip, j, fmt::format("the home mark moved by {:.0f} counts", repeat));
    result.findings.push_back(found);
    return;
  }
  const double ways = std::abs(mean(passes.forward) - mean(passes.backward));
  if (ways > kBothWays * encoder.counts_per_turn.value)
    result.findings.push_back(
        finding(arm, ArmFault::kIndexOff, j, fmt::format("{:.0f} counts between the two directions", ways)));
  const double at = context.known.at_zero.at(j) +
                    .5 * (mean(passes.forward) + mean(passes.backward)) * arm.axis(j).per_count();
  const double turn = (arm.axis(j).is_prismatic ? 1.0 : 2 * std::numbers::pi) / encoder.turns_per_turn.value;
  const double off = (at - arm.axis(j).home.value) / turn;
  if (std::abs(off) > kElsewhere)
    result.findings.push_back(finding(arm, ArmFault::kIndexOff, j,
                                      fmt::format("{:.2f} turns of the encoder from home", off),
                                      std::round(off)));
  Measure measure;
  measure.name = "home_mark_turns";
  measure.axis = static_cast<int>(j);
  measure.given = 0;
  measure.value = off;
  measure.spread = repeat / encoder.counts_per_turn.value;
  result.measures.push_back(measure);
}

// How far apart the marks of an axis are, and how far from its home their middle is, rad.
struct MarkSeen {
  double width = 0, off = 0;
};

MarkSeen mark_seen(const StepContext& context, std::size_t j,
                   const std::vector<PerAxis<std::int64_t>>& at_home) {
  std::vector<double> counts;
  counts.reserve(at_home.size());
  for (const PerAxis<std::int64_t>& at : at_home) counts.push_back(static_cast<double>(at.at(j)));
  const double rad_per_count = context.arm.axis(j).per_count() / per_radian(context.arm.axis(j));
  const double home =
      (context.known.at_zero.at(j) - context.arm.axis(j).home.value) / per_radian(context.arm.axis(j));
  return {std::abs(rad_per_count) * range_of(counts), home + mean(counts) * rad_per_count};
}

// A mark of the whole arm. The device counts from it, so where it was seen is home from now on.
StepResult prove_home(StepContext& context) {
  constexpr int kTimes = 3;
  constexpr double kWidth_rad = .01;      // a device that sees it farther from home reports index_mismatch
  constexpr double kElsewhere_rad = .05;  // of the place that the stops tell
  const Expectation& arm = context.arm;
  Prompt asked = prompt(Prompt::Kind::kPassHome, arm.axes(),
                        fmt::format("Bring the arm slowly to its home mark and away from it, {} times, each "
                                    "time from another side.",
                                    kTimes));
  asked.times = kTimes;
  for (std::size_t j = 0; j < arm.axes(); ++j) asked.place.at(j) = arm.axis(j).home.value;
  const std::vector<PerAxis<std::int64_t>> at_home = context.bench.watch(asked, false).at_home;
  StepResult result;
  if (at_home.size() < kTimes) {
    result.findings.push_back(finding(ArmFault::kIndexOff, "The arm",
                                      fmt::format("it was seen {} of {} times", at_home.size(), kTimes)));
    return result;
  }
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const MarkSeen seen = mark_seen(context, j, at_home);
    if (seen.width > kWidth_rad)
      result.findings.push_back(finding(
          arm, ArmFault::kIndexOff, j,
          fmt::format("it comes at places {:.3f} rad apart, {} rad are allowed", seen.width, kWidth_rad)));
    else if (std::abs(seen.off) > kElsewhere_rad)
      result.findings.push_back(
          finding(arm, ArmFault::kIndexOff, j, fmt::format("{:.3f} rad from home, by the stops", seen.off)));
    Measure measure;
    measure.name = "home_mark_rad";
    measure.axis = static_cast<int>(j);
    measure.given = 0;
    measure.value = seen.off;
    measure.spread = seen.width;
    result.measures.push_back(measure);
  }
  result.passed = result.findings.empty();
  if (!result.passed) return result;
  for (const Measure& measure : result.measures) {
    const auto j = static_cast<std::size_t>(measure.axis);
    context.known.at_zero.at(j) -= measure.value * per_radian(arm.axis(j));
  }
  return result;
}

}  // namespace

StepResult prove_encoders(StepContext& context) {
  StepResult result;
  std::vector<Turn> turns;
  turns.reserve(context.arm.axes());
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    turns.push_back(
        read_turn(context.bench.watch(turn_prompt(context.arm, j, 3, false), false), j, context.arm.axes()));
    const Turn again =
        read_turn(context.bench.watch(turn_prompt(context.arm, j, 1, true), false), j, context.arm.axes());
    turns.back().first_against = again.counter.at(j).first;
  }
  result.findings = judge_turns(context.arm, turns, result.notes);
  result.passed = result.findings.empty();
  if (!result.passed) return result;
  context.known.at_zero = place_of_stops(context.arm, turns);
  context.known.resting = {};
  context.known.session = context.bench.facts().session;
  context.bench.locate(context.known.at_zero);
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    Measure measure;
    measure.name = "counts_between_stops";
    measure.axis = static_cast<int>(j);
    const Expectation::Span span = context.arm.span(j, context.arm.home());
    measure.given = std::abs(context.arm.counts(j, span.upper - span.lower));
    measure.value = turns[j].counter.at(j).way();
    measure.spread = turns[j].counter.at(j).return_error();
    result.measures.push_back(measure);
  }
  return result;
}

StepResult prove_marks(StepContext& context) {
  StepResult result;
  switch (context.bench.facts().home_mark) {
    case HomeMark::kNone:
      result.passed = true;
      result.notes.emplace_back("This arm has no home mark: it is homed by its stops or in its rest.");
      return result;
    case HomeMark::kWholeArm:
      return prove_home(context);
    case HomeMark::kEachAxis:
      break;
  }
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    const BenchRecording recording = context.bench.watch(turn_prompt(context.arm, j, 3, false), false);
    Passes passes;
    for (const Mark& mark : recording.marks)
      if (mark.axis == j)
        (mark.forward ? passes.forward : passes.backward).push_back(static_cast<double>(mark.counts));
    if (passes.forward.empty() || passes.backward.empty()) {
      result.findings.push_back(
          finding(context.arm, ArmFault::kIndexOff, j, "it was not seen between the stops"));
      continue;
    }
    judge_mark(context, j, passes, result);
  }
  result.passed = result.findings.empty();
  return result;
}

}  // namespace thimble::host
