#include "host-tools/sweep/sweep_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::string_view kSearchColumns = "status,largest_stable,tried";

// In the results. Everything but ok and the end of a search is a run without figures, or with those up to a fault.
std::string_view word(board::SimulationStatus status) {
  using board::SimulationStatus;
  switch (status) {
    case SimulationStatus::kOk:
      return "ok";
    case SimulationStatus::kImageRefused:
      return "scene-refused";
    case SimulationStatus::kUnknownArm:
      return "unknown-arm";
    case SimulationStatus::kBadRate:
      return "bad-rate";
    case SimulationStatus::kBadPath:
      return "bad-path";
    case SimulationStatus::kOutOfReach:
      return "out-of-reach";
    case SimulationStatus::kNotArmed:
      return "not-armed";
    case SimulationStatus::kFaulted:
      return "faulted";
  }
  return "";
}

}  // namespace

std::string SweepRuns::head() const {
  std::string text = fmt::format("# thimble sweep, plan {:08x}\nrun", plan_.crc);
  for (const SweepAxis& axis : plan_.axes) text += "," + axis.what;
  text += ",";
  if (plan_.search) return text.append(kSearchColumns) + "\n";
  text += "status";
  for (const MeasureColumn& column : measure_columns()) text.append(",").append(column.name);
  return text.append(",").append(kStable) + "\n";
}

std::size_t SweepRuns::columns() const {
  const std::string text = head();
  return 1 + static_cast<std::size_t>(
                 std::count(text.begin() + static_cast<std::ptrdiff_t>(text.find('\n')), text.end(), ','));
}

SweepSettings SweepRuns::settings(std::size_t run) const {
  SweepSettings settings = plan_.base;
  const std::vector<std::size_t> place = plan_.place(run);
  // A whole hand first, in whatever order the axes are: it would undo what says one of its numbers.
  for (const bool whole_hand : {true, false}) {
    for (std::size_t i = 0; i < place.size(); ++i)
      if ((plan_.axes[i].what == "hand") == whole_hand) plan_.axes[i].values[place[i]].set(settings);
    if (whole_hand)
      for (const SweepValue& number : plan_.hand_numbers) number.set(settings);
  }
  return settings;
}

double SweepRuns::cost(std::size_t run) const {
  const SweepSettings of_run = settings(run);
  return of_run.press.rate_Hz * (plan_.scene == nullptr ? of_run.press.hold_s : 1);
}

MeasuredRun SweepRuns::input(const SweepSettings& settings) const {
  if (plan_.scene == nullptr) return run_of(settings.press);
  MeasuredRun run;
  run.image = plan_.scene->compile(settings.scene).image;
  run.path = plan_.path;
  run.options.ideal = plan_.ideal;
  run.options.rate_Hz = settings.press.rate_Hz;
  run.options.arm = settings.press.arm;
  run.options.arm_data = settings.press.arm_data;
  run.options.seed = settings.press.seed;
  run.options.trial = settings.trial;
  run.options.hand = settings.press.hand;
  run.along = plan_.along;
  if (plan_.steady_s > 0)
    run.steady_from_s = std::ranges::max(plan_.path, {}, &board::PathPoint::time_s).time_s - plan_.steady_s;
  return run;
}

SweepRuns::Outcome SweepRuns::outcome(const SweepSettings& settings,
                                      const std::function<void()>& go_on) const {
  try {
    Outcome outcome{measure(input(settings), go_on), {}};
    outcome.status = word(outcome.measured.status);
    return outcome;
  } catch (const Error&) {  // each value alone was good, but not these together
    Outcome outcome;
    outcome.measured.status = board::SimulationStatus::kImageRefused;
    outcome.status = word(outcome.measured.status);
    return outcome;
  }
}

std::string SweepRuns::search(SweepSettings settings, const std::function<void()>& go_on) const {
  std::string last = "0";
  std::size_t tried = 0;
  for (const SweepValue& value : plan_.search->values) {
    value.set(settings);
    const Outcome now = outcome(settings, go_on);
    ++tried;
    if (!now.measured.is_ok() && now.measured.status != board::SimulationStatus::kFaulted)
      return fmt::format("{},,{}", now.status, tried);
    if (!now.measured.is_still(plan_.still_m)) return fmt::format("ok,{},{}", last, tried);
    last = value.text;
  }
  return fmt::format("all-stable,{},{}", last, tried);
}

std::string SweepRuns::line(std::size_t run, const std::function<void()>& go_on) const {
  std::string line = std::to_string(run);
  const std::vector<std::size_t> place = plan_.place(run);
  for (std::size_t i = 0; i < place.size(); ++i) line += "," + plan_.axes[i].values[place[i]].text;
  line += ",";
  if (plan_.search) return line + search(settings(run), go_on);
  const Outcome now = outcome(settings(run), go_on);
  line += now.status;
  const bool has_figures = now.measured.is_ok() || now.measured.status == board::SimulationStatus::kFaulted;
  const bool has_steady = now.measured.is_ok() && (plan_.scene == nullptr || plan_.steady_s > 0);
  for (const MeasureColumn& column : measure_columns()) {
    line += ",";
    if (has_figures && (!column.is_steady || has_steady))
      line += fmt::format("{:.9g}", now.measured.*column.value);
  }
  line += ",";
  if (has_figures && (plan_.scene == nullptr || plan_.steady_s > 0))
    line += now.measured.is_still(plan_.still_m) ? "1" : "0";
  return line;
}

}  // namespace thimble::host
