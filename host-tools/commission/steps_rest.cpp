// Steps 0 and 1: lines, and an arm at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host-tools/commission/steps.h"

namespace thimble::host {
namespace {

constexpr double kRest_s = 5;
constexpr std::int64_t kQuietCounts = 1, kQuietCountsPowered = 2;

void judge_quiet(const StepContext& context, const BenchRecording& recording, bool powered,
                 StepResult& result) {
  const BenchFacts facts = context.bench.facts();
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    std::int64_t low = 0, high = 0;
    for (const BenchTick& tick : recording.ticks) {
      const std::int64_t moved = tick.counts.at(j) - recording.ticks.front().counts.at(j);
      low = std::min(low, moved);
      high = std::max(high, moved);
    }
    const std::uint64_t illegal = facts.counts_illegal ? recording.illegal.at(j) : 0;
    if (high - low <= (powered ? kQuietCountsPowered : kQuietCounts) && illegal == 0) continue;
    const bool known = std::ranges::any_of(
        result.findings, [j](const ArmFinding& found) { return found.axis == static_cast<int>(j); });
    if (known) continue;
    result.findings.push_back(finding(
        context.arm, ArmFault::kNoise, j,
        fmt::format("{} counts and {} transitions that no encoder makes in {:.0f} s at rest, drives {}",
                    high - low, illegal, kRest_s, powered ? "on" : "off")));
  }
}

}  // namespace

StepResult prove_lines(StepContext& context) {
  struct Trial {
    Line line;
    Prompt::Kind kind;
    const char* name;
    const char* text;
  };
  constexpr std::array kTrials{Trial{Line::kEStop, Prompt::Kind::kOpenEStop, "e-stop", "Press the e-stop."},
                               Trial{Line::kDeadMan, Prompt::Kind::kReleaseDeadMan, "dead-man switch",
                                     "Hold the dead-man switch, then release it."},
                               Trial{Line::kWatchdog, Prompt::Kind::kStopHost, "watchdog",
                                     "Nothing to do: this program is silent for a moment."}};
  const BenchFacts facts = context.bench.facts();
  StepResult result;
  for (const Trial& trial : kTrials) {
    const LineTrial seen = context.bench.try_line(trial.line, prompt(trial.kind, 0, trial.text));
    // A line is seen in one tick; the tick in which it fell is not known.
    const double most_s = trial.line == Line::kWatchdog ? facts.watchdog_s : 2 * facts.tick_s;
    if (seen.fell && seen.seconds <= most_s) {
      result.notes.push_back(fmt::format("{}: drives off after {:.2g} ms", trial.name, 1e3 * seen.seconds));
      continue;
    }
    result.findings.push_back(finding(ArmFault::kLineIgnored, fmt::format("The {}", trial.name),
                                      seen.fell ? fmt::format("off after {:.2g} ms, {:.2g} ms are allowed",
                                                              1e3 * seen.seconds, 1e3 * most_s)
                                                : "they stayed on"));
  }
  result.passed = result.findings.empty();
  return result;
}

StepResult prove_quiet(StepContext& context) {
  StepResult result;
  const Answer answer = context.bench.ask(
      prompt(Prompt::Kind::kRest, 0, "Lay the arm so that it rests, and take your hands off it."));
  if (answer == Answer::kStop) return {.stopped = true};
  judge_quiet(context, context.bench.wait(kRest_s, false), false, result);
  judge_quiet(context, context.bench.wait(kRest_s, true), true, result);
  result.passed = result.findings.empty();
  return result;
}

}  // namespace thimble::host
