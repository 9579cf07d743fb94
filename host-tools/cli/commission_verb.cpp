// commission: an arm is proved and measured step by step.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>

#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/cli/commission_on_page.h"
#include "host-tools/cli/commissioned_arm.h"
#include "host-tools/cli/console_person.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/commission/procedure.h"
#include "host-tools/commission/state.h"
#include "host-tools/files/file_lock.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/viewer/view.h"

namespace thimble::host {
namespace {

constexpr const char* kStateKey = "thimble_commission";

struct Places {
  std::filesystem::path arm, state, result, report;
};

// Beside the arm file. Of an arm that comes with Thimble: in the working folder, because its own is not the user's.
Places places_of(const CommissionChoice& choice) {
  Places places;
  places.arm = arm_path(choice.model);
  const bool comes_with_it = places.arm != std::filesystem::path(choice.model);
  const std::filesystem::path folder = comes_with_it ? std::filesystem::path() : places.arm.parent_path();
  std::string name = places.arm.filename().string();
  if (name.ends_with(kArmSuffix)) name.resize(name.size() - std::string_view(kArmSuffix).size());
  places.result = folder / fmt::format("{}.commissioned{}", name, kArmSuffix);
  places.report = folder / fmt::format("{}.commission.md", name);
  places.state = choice.state.empty() ? folder / fmt::format("{}.commission.json", name) : choice.state;
  for (const std::filesystem::path* output : {&places.state, &places.result, &places.report})
    keep_apart(places.arm, *output);
  // They may not be there yet.
  const auto whole = [](const std::filesystem::path& file) {
    std::error_code none;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, none), none);
  };
  for (const std::filesystem::path* output : {&places.result, &places.report})
    if (whole(*output) == whole(places.state))
      throw Error(ExitCode::kUsage, "same-file",
                  places.state.string() + " is written with the result, and cannot keep the progress",
                  "give --state another name");
  return places;
}

bool is_there(const std::filesystem::path& file) {
  std::error_code none;
  return std::filesystem::exists(file, none);
}

std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))); }

Commission read_state(const std::filesystem::path& file, const std::string& saved) {
  try {
    return Commission::from_state(saved);
  } catch (const Error& error) {
    throw Error(error.code, error.name, file.string() + " " + error.cause,
                "begin anew with --restart, or give another file with --state");
  }
}

// Goes on with the saved state, or begins anew.
Commission open_commission(const Places& places, const std::string& arm_text, bool restart, bool simulated) {
  if (is_there(places.state)) {
    const std::string saved = read_input(places.state);
    const bool is_state = saved.empty() || saved.find(kStateKey) != std::string::npos;
    if (!is_state)
      throw Error(ExitCode::kBadInput, "bad-state",
                  fmt::format("{} is no saved commissioning", places.state.string()),
                  "give another file with --state");
    if (!restart) {
      Commission commission = read_state(places.state, saved);
      if (commission.is_of(arm_text)) return commission;
      throw Error(ExitCode::kBadInput, "arm-changed",
                  fmt::format("{} is not the arm file with which the commissioning in {} began",
                              places.arm.string(), places.state.string()),
                  "begin anew with --restart, or give another file with --state");
    }
  }
  return {arm_text, places.arm.string(), (simulated ? "simulated commission " : "commission ") + today()};
}

std::string quantity(const Measure& measure, const ArmFile& arm) {
  std::string text = measure.name;
  if (measure.axis >= 0) text = arm.axes[static_cast<std::size_t>(measure.axis)].name + " " + text;
  if (!std::isnan(measure.rate_Hz)) text += fmt::format(" (B = {:.2g} N s/m)", measure.damping_N_s_m);
  return text;
}

// One run of the verb.
class Session {
 public:
  Session(const Common& common, const Remote& remote, const CommissionChoice& choice, const Places& places,
          const std::string& arm_text, const ArmFile& arm, CommissionOnPage* page)
      : common_(common),
        choice_(choice),
        places_(places),
        state_name_(places.state.string()),
        commission_(open_commission(places, arm_text, choice.restart, choice.simulate)),
        page_(page),
        arm_(commissioned_arm(common, remote, choice, choice.simulate ? arm : commission_.arm(), state_name_,
                              page)),
        watched_(page == nullptr ? nullptr : std::make_unique<WatchedBench>(arm_->bench(), *page)),
        bench_(page == nullptr ? arm_->bench() : *watched_) {
    if (page_ != nullptr)
      page_->follow([this] { return arm_->counts(); }, [this] { static_cast<void>(arm_->bench().read()); });
    if (commission_.bench().is_object()) arm_->demand_same(commission_.bench());
    commission_.tell_bench(arm_->identity());
    // A folder that cannot be written is found before the work.
    commission_.save(places_.state);
    for (const std::filesystem::path* output : {&places_.result, &places_.report})
      static_cast<void>(OutputFile(*output));
  }

  void run() {
    heed_interrupts();
    if (choice_.step) {
      do_step(*choice_.step);
    } else {
      while (!is_over_ && commission_.next() <= last()) do_step(commission_.next());
    }
    heed_interrupts_no_more();
    finish();
  }

 private:
  static int last() { return static_cast<int>(steps().size()) - 1; }

  template <class... T>
  void tell(fmt::format_string<T...> format, T&&... values) const {
    if (!common_.json) say(stderr, format, std::forward<T>(values)...);
  }

  // With its repetitions after a correction or a repair; before it step 2, where the counters have begun anew.
  void do_step(int number) {
    if (number != 2 && commission_.passed(2) && commission_.next() >= number &&
        commission_.needs_place(number, bench_)) {
      tell("The counters have begun anew: step 2 comes again, then step {}.\n", number);
      do_step(2);
      if (is_over_ || !commission_.passed(2)) return;
    }
    constexpr int kMostRepeats = 6;
    for (int repeats = 0; repeats < kMostRepeats; ++repeats) {
      if (once(number) || is_over_) return;
      while (!is_over_ && commission_.next() < number) do_step(commission_.next());  // what is void now
      if (is_over_) return;
    }
    is_over_ = true;
  }

  // Whether the step has passed.
  bool once(int number) {
    const Step& step = steps()[static_cast<std::size_t>(number)];
    arm_->begin_step(number);
    if (page_ != nullptr) page_->show_steps(commission_.results(), number);
    tell("step {} of {}, {}: {}\n", number, last(), step.name, step.text);
    const std::size_t corrections = commission_.corrections().size();
    try {
      std::optional<Busy> busy;
      if (!arm_->is_asked()) busy.emplace(common_.json, std::string(step.name));
      static_cast<void>(commission_.run(number, bench_));
    } catch (const BuilderStops&) {
      stop(number);
    }
    commission_.save(places_.state);
    if (page_ != nullptr) page_->show_steps(commission_.results(), {});
    const StepResult& result = commission_.results().at(number);
    for (const ArmFinding& found : result.findings) {
      // With --ask the question about a correction has said the rest.
      const bool was_said = choice_.ask && !found.corrections.empty();
      tell("  ! {}{}{}\n", text_of(found.fault).name, was_said ? "" : ": ", was_said ? "" : found.text);
    }
    for (const std::string& note : result.notes) tell("    {}\n", note);
    if (arm_->stopped()) stop(number);
    if (result.passed) {
      tell("  passed\n");
      return true;
    }
    failed_ = number;
    if (commission_.corrections().size() > corrections) {
      tell("  Corrected in the new file; the step comes again.\n");
    } else if (!arm_->is_asked() || result.findings.empty() || !repaired(result)) {
      is_over_ = true;
    }
    return false;
  }

  // A person repairs what was found.
  bool repaired(const StepResult& result) {
    Prompt prompt;
    prompt.kind = Prompt::Kind::kRepair;
    const int axis = result.findings.front().axis;
    prompt.axis = axis < 0 ? commission_.arm().axes.size() : static_cast<std::size_t>(axis);
    prompt.text = "Repair it; then the step comes again.";
    try {
      if (bench_.ask(prompt) != Answer::kDone) return false;
    } catch (const BuilderStops&) {
      return false;
    }
    arm_->repaired(result);
    return true;
  }

  [[noreturn]] void stop(int number) const {
    throw Error(
        ExitCode::kRefused, "interrupted",
        fmt::format("stopped in step {}; what passed before is in {}", number, places_.state.string()),
        "give the same command again: it goes on with this step");
  }

  void finish() {
    write(places_.report, commission_.report());
    const bool complete = commission_.next() > last();
    std::vector<std::string> warnings;
    if (complete) {
      const std::string text = commission_.arm_file(choice_.simulate ? "" : today());
      try {
        warnings = check_arm(read_arm_file(text, places_.result.string()), places_.result.string()).warnings;
      } catch (const Error& error) {
        throw Error(ExitCode::kVerification, "bad-result",
                    "the arm file with the measured values cannot work, and was not written: " + error.cause,
                    fmt::format("compare measured with given in {}", places_.report.string()));
      }
      write(places_.result, text);
    } else if (is_there(places_.result)) {
      warnings.push_back(fmt::format("{} is the result of an earlier run", places_.result.string()));
    }
    common_.json ? print_json(complete, warnings) : print_text(complete, warnings);
    fail_if_found();
    if (page_ == nullptr) return;
    page_->end(true, complete
                         ? fmt::format("All steps passed. The new arm file is {}, and the report {}.",
                                       places_.result.string(), places_.report.string())
                         : fmt::format("Step {} passed; the next is {}.", *choice_.step, commission_.next()));
  }

  static void write(const std::filesystem::path& file, const std::string& text) {
    OutputFile output(file);
    output.stream() << text;
    output.commit();
  }

  // Of the steps of this run, and those before: what has not passed.
  void fail_if_found() const {
    if (failed_ < 0 || commission_.passed(failed_)) return;
    std::fflush(stdout);
    const StepResult& result = commission_.results().at(failed_);
    std::string cause = fmt::format("step {} has not passed", failed_);
    bool is_file_doubtful = false;
    for (const ArmFinding& found : result.findings) {
      cause += fmt::format("; {}: {}", text_of(found.fault).name, found.text);
      is_file_doubtful = is_file_doubtful || !found.corrections.empty();
    }
    if (result.findings.empty())
      for (const std::string& note : result.notes) cause += "; " + note;
    throw Error(ExitCode::kVerification, "arm-fault", cause,
                fmt::format("repair it, then give the command again: it goes on with step {};{} {}",
                            commission_.next(),
                            is_file_doubtful && choice_.simulate
                                ? " where the arm is right and the file is wrong, give "
                                  "--accept-corrections;"
                                : "",
                            places_.report.string()));
  }

  // Where a step has failed, the error says all.
  void print_text(bool complete, const std::vector<std::string>& warnings) const {
    for (const std::string& warning : warnings) say(stderr, "warning: {}\n", warning);
    if (failed_ >= 0 && !commission_.passed(failed_)) return;
    const ArmFile& arm = commission_.arm();
    if (!complete) {
      say("{}: step {} passed; the next is {}\n", arm.name, *choice_.step, commission_.next());
      return;
    }
    say("{}: all steps passed, {} corrections\n", arm.name, commission_.corrections().size());
    say("  {:<36} {:>10} {:>10} {:>9}\n", "measured", "value", "given", "spread");
    for (const auto& [number, result] : commission_.results())
      for (const Measure& measure : result.measures)
        if (!place_of(measure).empty())
          say("  {:<36} {:>10.5g} {:>10} {:>9.2g}\n", quantity(measure, arm), measure.value,
              std::isnan(measure.given) ? "" : fmt::format("{:.4g}", measure.given), measure.spread);
    say("arm file: {}\nreport: {}\n", places_.result.string(), places_.report.string());
    if (!choice_.simulate) say("next: thimble model upload {}\n", places_.result.string());
  }

  void print_json(bool complete, const std::vector<std::string>& warnings) const {
    Json json = document("commission");
    json["name"] = commission_.arm().name;
    json["simulated"] = choice_.simulate;
    json["complete"] = complete;
    json["next"] = complete ? Json() : Json(commission_.next());
    json["state"] = places_.state.string();
    json["report"] = places_.report.string();
    json["arm"] = complete ? Json(places_.result.string()) : Json();
    json["corrections"] = Json::array();
    for (const Correction& correction : commission_.corrections())
      json["corrections"].push_back(json_of(correction));
    json["warnings"] = warnings;
    json["steps"] = Json::array();
    for (const auto& [number, result] : commission_.results()) {
      Json step{{"number", number}, {"step", steps()[static_cast<std::size_t>(number)].name}};
      step.update(json_of(result));
      for (Json& measure : step["measures"]) name_axes(measure);
      for (Json& found : step["findings"]) name_axes(found);
      json["steps"].push_back(step);
    }
    print(json);
  }

  // Axes by their names; null: of the whole arm.
  void name_axes(Json& entry) const {
    for (const char* key : {"axis", "other"}) {
      if (!entry.contains(key)) continue;
      const int axis = entry[key];
      entry[key] = axis < 0 ? Json() : Json(commission_.arm().axes[static_cast<std::size_t>(axis)].name);
    }
  }

  const Common& common_;
  const CommissionChoice& choice_;
  const Places& places_;
  const std::string state_name_;
  Commission commission_;
  CommissionOnPage* page_;  // or null
  std::unique_ptr<CommissionedArm> arm_;
  std::unique_ptr<WatchedBench> watched_;
  Bench& bench_;
  bool is_over_ = false;
  int failed_ = -1;  // the last step that did not pass in this run
};

void open_page(const CommissionOnPage& page, bool browser) {
  say(stderr, "page: {}\n", page.url());
  if (!browser) return;
  const std::string failed = open_browser(page.url());
  if (!failed.empty())
    say(stderr, "thimble: no browser was opened: {}\n  remedy: open the address above\n", failed);
}

}  // namespace

void commission(const Common& common, const Remote& remote, const CommissionChoice& given) {
  CommissionChoice choice = given;
  choice.ask = given.ask || (given.page && given.simulate);
  const Places places = places_of(choice);
  const std::string text = read_input(places.arm);
  const ArmFile arm = read_arm_file(text, places.arm.string());
  static_cast<void>(check_arm(arm, places.arm.string()));
  const Expectation expected(arm);
  for (std::size_t j = 0; j < arm.axes.size(); ++j)
    if (!expected.stays_closed(j, expected.home()))
      throw Error(
          ExitCode::kRefused, "links-part",
          fmt::format(
              "{}: axis '{}' cannot be turned from stop to stop while the others are at home: the links "
              "of the loop part or fold on the way",
              places.arm.string(), arm.axes[j].name),
          "give this axis narrower limits with stops that hold them, or another home");
  const FileLock lock(places.state);
  if (!lock.held())
    throw Error(ExitCode::kRefused, "state-in-use",
                "another commissioning works with " + places.state.string(),
                "wait until it has ended, or give another file with --state");
  if (!choice.page) {
    Session(common, remote, choice, places, text, arm, nullptr).run();
    return;
  }
  CommissionOnPage page(choice, arm);
  open_page(page, choice.browser);
  try {
    Session(common, remote, choice, places, text, arm, &page).run();
  } catch (const Error& error) {
    page.end(false, fmt::format("{}: {}. Remedy: {}.", error.name, error.cause, error.remedy));
    throw;
  }
}

}  // namespace thimble::host
