#include "host-tools/cli/commission_on_page.h"

#include <fmt/format.h>

#include "host-tools/arms/arm_data.h"
#include "host-tools/commission/faults.h"

namespace thimble::host {
namespace {

constexpr auto kReadPeriod = std::chrono::milliseconds(200);

CommissionPageOptions page_options(const CommissionChoice& choice, const ArmFile& arm) {
  CommissionPageOptions options;
  options.web = {choice.listen, choice.port};
  options.version = THIMBLE_VERSION;
  options.arm = arm.name;
  options.simulated = choice.simulate;
  options.axes.reserve(arm.axes.size());
  for (const ArmAxis& axis : arm.axes) options.axes.push_back(axis.name);
  options.steps.reserve(steps().size());
  for (const Step& step : steps()) options.steps.push_back({std::string(step.name), std::string(step.text)});
  return options;
}

// The axis that a prompt is about; of the other kinds it is about the whole arm.
std::optional<std::size_t> axis_in_question(const Prompt& prompt) {
  switch (prompt.kind) {
    case Prompt::Kind::kTurn:
    case Prompt::Kind::kPlace:
    case Prompt::Kind::kSwing:
    case Prompt::Kind::kLetGo:
    case Prompt::Kind::kRepair:
    case Prompt::Kind::kAcceptCorrection:
      return prompt.axis;
    case Prompt::Kind::kOpenEStop:
    case Prompt::Kind::kReleaseDeadMan:
    case Prompt::Kind::kStopHost:
    case Prompt::Kind::kRest:
    case Prompt::Kind::kPassHome:
    case Prompt::Kind::kMoveAbout:
    case Prompt::Kind::kPush:
    case Prompt::Kind::kHang:
    case Prompt::Kind::kPressWall:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

CommissionOnPage::CommissionOnPage(const CommissionChoice& choice, const ArmFile& arm)
    : page_(page_options(choice, arm), arm_data(arm)), arm_(arm) {}

void CommissionOnPage::ask(const Prompt& prompt, bool bench_waits) {
  read_due_.reset();
  if (bench_waits) read_due_ = std::chrono::steady_clock::now();
  look();
  CommissionPrompt shown;
  shown.text = prompt.text;
  const bool about_correction = prompt.kind == Prompt::Kind::kAcceptCorrection;
  if (about_correction) shown.done = "Yes";
  if (may_be_declined(prompt)) shown.decline = about_correction ? "No" : "Decline";
  shown.axis = axis_in_question(prompt);
  if (shown.axis && *shown.axis >= arm_.axes.size()) shown.axis.reset();
  if (prompt.kind == Prompt::Kind::kTurn) shown.turn = prompt.sign;
  shown.way = prompt.direction;
  if (prompt.kind == Prompt::Kind::kPlace || prompt.kind == Prompt::Kind::kPassHome)
    shown.goal.emplace(prompt.place.begin(),
                       prompt.place.begin() + static_cast<std::ptrdiff_t>(arm_.axes.size()));
  page_.ask(std::move(shown));
}

void CommissionOnPage::withdraw() {
  read_due_.reset();
  page_.withdraw();
}

// A device that does not answer is for the bench to tell: the picture stays then.
void CommissionOnPage::read_if_due() {
  const auto now = std::chrono::steady_clock::now();
  if (!at_zero_ || !read_ || !read_due_ || now < *read_due_) return;
  try {
    read_();
    read_due_ = now + kReadPeriod;
  } catch (const Error&) {
    read_due_.reset();
  }
}

std::optional<Answer> CommissionOnPage::answer() {
  read_if_due();
  look();
  const std::optional<CommissionPage::Answer> answer = page_.answer();
  if (!answer) return std::nullopt;
  return *answer == CommissionPage::Answer::kDone ? Answer::kDone : Answer::kNo;
}

void CommissionOnPage::look() {
  std::vector<double> axes;
  const std::optional<PerAxis<std::int64_t>> counts =
      counts_ && at_zero_ ? counts_() : std::optional<PerAxis<std::int64_t>>();
  if (counts) {
    axes.reserve(arm_.axes.size());
    for (std::size_t j = 0; j < arm_.axes.size(); ++j)
      axes.push_back(at_zero_->at(j) + static_cast<double>(counts->at(j)) * arm_.axes[j].per_count());
  }
  if (axes == shown_) return;
  shown_ = axes;
  page_.change([&](CommissionShown& shown) { shown.axes = axes; });
}

void CommissionOnPage::show_steps(const std::map<int, StepResult>& results, std::optional<int> now) {
  // What step 2 said of the counters is not known before it has passed again.
  if (now && !steps()[static_cast<std::size_t>(*now)].needs_place) at_zero_.reset();
  look();
  page_.change([&](CommissionShown& shown) {
    for (CommissionStepShown& step : shown.steps) step = {};
    for (const auto& [number, result] : results) {
      CommissionStepShown& step = shown.steps.at(static_cast<std::size_t>(number));
      step.state = result.passed ? "passed" : "found";
      step.notes = result.notes;
      for (const ArmFinding& found : result.findings)
        step.findings.push_back({std::string(text_of(found.fault).name), found.text});
    }
    if (now) shown.steps.at(static_cast<std::size_t>(*now)).state = "now";
    shown.doing.clear();
    shown.axis.reset();
  });
}

void CommissionOnPage::say_doing(const std::string& what, std::optional<std::size_t> axis) {
  page_.change([&](CommissionShown& shown) {
    shown.doing = what;
    shown.axis = axis;
  });
}

void CommissionOnPage::end(bool passed, const std::string& text) {
  page_.change([&](CommissionShown& shown) {
    shown.over = {passed, text};
    shown.doing.clear();
    shown.axis.reset();
    for (CommissionStepShown& step : shown.steps)
      if (step.state == "now") step.state = "not yet";
  });
}

void WatchedBench::use(const ArmFile& arm) {
  page_.use(arm);
  bench_.use(arm);
}

void WatchedBench::locate(const PerAxis<double>& at_zero) {
  bench_.locate(at_zero);
  page_.locate(at_zero);
  page_.look();
}

Answer WatchedBench::ask(const Prompt& prompt) {
  const Answer answer = bench_.ask(prompt);
  page_.look();
  return answer;
}

LineTrial WatchedBench::try_line(Line line, const Prompt& prompt) {
  page_.say_doing(prompt.text);
  return bench_.try_line(line, prompt);
}

BenchRecording WatchedBench::watch(const Prompt& prompt, bool powered) {
  page_.say_doing("");
  BenchRecording recording = bench_.watch(prompt, powered);
  page_.look();
  return recording;
}

BenchRecording WatchedBench::wait(double seconds, bool powered) {
  page_.say_doing(fmt::format("Nothing to do for {:.0f} s: the counters are watched, with the drives {}.",
                              seconds, powered ? "on" : "off"));
  return bench_.wait(seconds, powered);
}

BenchRecording WatchedBench::run(const AxisProgram& program) {
  page_.say_doing(fmt::format("The motor of '{}' moves it: nothing to do.", page_.axis_name(program.axis)),
                  program.axis);
  BenchRecording recording = bench_.run(program);
  page_.look();
  return recording;
}

BenchRecording WatchedBench::servo(const ServoProgram& program) {
  page_.say_doing("The arm moves by itself: keep out of its reach.");
  BenchRecording recording = bench_.servo(program);
  page_.look();
  return recording;
}

BenchRecording WatchedBench::feel(const TipProgram& program, const Prompt& prompt) {
  page_.say_doing("");
  BenchRecording recording = bench_.feel(program, prompt);
  page_.look();
  return recording;
}

}  // namespace thimble::host
