#include "host-tools/commission/procedure.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "host-tools/commission/state.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

// Where a measured value goes in the file of an arm.
struct ResultPlace {
  const char* measure;
  const char* key;  // below the axis
};
constexpr std::array kResultPlaces{ResultPlace{"torque_constant_N_m_A", "motor/torque_constant_N_m_A"},
                                   ResultPlace{"resistance_ohm", "motor/resistance_ohm"},
                                   ResultPlace{"coulomb_N_m", "friction/coulomb_N_m"},
                                   ResultPlace{"viscous_N_m_s_rad", "friction/viscous_N_m_s_rad"},
                                   ResultPlace{"stiction_ratio", "friction/stiction_ratio"},
                                   ResultPlace{"stiffness_N_m_rad", "stiffness_N_m_rad"},
                                   ResultPlace{"first_resonance_Hz", "first_resonance_Hz"}};

double rounded(double value) { return std::stod(fmt::format("{:.4g}", value)); }

// Axes may share a motor by its name: one that differs gets its own.
void own_motor(Json& arm, const std::string& pointer) {
  const std::size_t at = pointer.find("/motor/");
  if (at == std::string::npos) return;
  Json& motor = arm[Json::json_pointer(pointer.substr(0, at + 6))];
  if (motor.is_string()) motor = Json(arm.at("motors").at(motor.get<std::string>()));
}

// Prunes motors that no axis names any more.
void drop_unused_motors(Json& arm) {
  if (!arm.contains("motors")) return;
  Json used = Json::object();
  for (const Json& axis : arm.at("axes"))
    if (axis.contains("motor") && axis.at("motor").is_string()) {
      const auto name = axis.at("motor").get<std::string>();
      used[name] = arm.at("motors").at(name);
    }
  if (used.empty()) {
    arm.erase("motors");
  } else {
    arm["motors"] = used;
  }
}

}  // namespace

Commission::Commission(std::string arm_text, std::string arm_name, std::string by)
    : name_(std::move(arm_name)), by_(std::move(by)) {
  static_cast<void>(read_arm_file(arm_text, name_));  // its errors tell the line
  arm_ = Json::parse(arm_text);
  reread();
}

void Commission::reread() {
  file_ = std::make_unique<ArmFile>(read_arm_file(arm_.dump(2), name_));
  expectation_ = std::make_unique<Expectation>(*file_);
}

const StepResult& Commission::run(int number, Bench& bench) {
  const Step& step = steps()[static_cast<std::size_t>(number)];
  if (number > 0 && !passed(number - 1) && next() < number)
    throw Error(ExitCode::kRefused, "step-order",
                fmt::format("step {} builds on step {}, which has not passed", number, next()),
                fmt::format("do step {} first", next()));
  if (step.needs_place && known_.session != bench.facts().session)
    throw Error(ExitCode::kRefused, "step-order", "the counters have begun anew since step 2",
                "do step 2 again");
  bench.use(*file_);
  if (step.needs_place) bench.locate(known_.at_zero);
  StepContext context{bench, *expectation_, known_};
  StepResult result = step.run(context);
  // What later steps found of another arm, or of this one before it was repaired, is void.
  if (!result.passed) results_.erase(results_.upper_bound(number), results_.end());
  StepResult& kept = results_[number] = std::move(result);
  accept(kept, bench);
  return kept;
}

void Commission::accept(const StepResult& result, Bench& bench) {
  bool corrected = false;
  for (std::size_t i = 0; i < result.findings.size(); ++i) {
    const Finding& found = result.findings[i];
    if (found.corrections.empty()) continue;
    Prompt asked = prompt(Prompt::Kind::kAcceptCorrection, static_cast<std::size_t>(std::max(0, found.axis)),
                          found.text + " Is the arm right as it is, and the file wrong?");
    asked.finding = i;
    if (bench.ask(asked) != Answer::kDone) continue;
    for (const Correction& correction : found.corrections) correct(correction);
    corrected = true;
  }
  if (corrected) reread();
}

void Commission::correct(const Correction& correction) {
  own_motor(arm_, correction.pointer);
  Json& value = arm_[Json::json_pointer(correction.pointer)];
  if (correction.value == std::trunc(correction.value) && std::abs(correction.value) < 1e9) {
    value = static_cast<std::int64_t>(correction.value);
  } else {
    value = {{"value", rounded(correction.value)}, {"by", by_}};
  }
}

bool Commission::passed(int number) const {
  const auto found = results_.find(number);
  return found != results_.end() && found->second.passed;
}

int Commission::next() const {
  int number = 0;
  while (number < static_cast<int>(steps().size()) && passed(number)) ++number;
  return number;
}

std::string Commission::arm_file() const {
  Json arm = arm_;
  for (const auto& [number, result] : results_) {
    for (const Measure& measure : result.measures) {
      for (const ResultPlace& place : kResultPlaces) {
        if (measure.name != place.measure || measure.axis < 0) continue;
        if (!(measure.spread <= measure.promise * std::abs(measure.value)) || !(measure.value >= 0)) continue;
        const std::string pointer = fmt::format("/axes/{}/{}", measure.axis, place.key);
        own_motor(arm, pointer);
        arm[Json::json_pointer(pointer)] = {
            {"value", rounded(measure.value)}, {"spread", rounded(measure.spread)}, {"by", by_}};
      }
    }
  }
  drop_unused_motors(arm);
  return arm.dump(2) + "\n";
}

std::string Commission::report() const {
  std::string text = fmt::format("Commissioning of {}\n", file_->name);
  auto out = std::back_inserter(text);
  for (const Step& step : steps()) {
    const auto found = results_.find(step.number);
    const char* word = found == results_.end() ? "not done" : found->second.passed ? "passed" : "FAILED";
    fmt::format_to(out, "\n{:2}  {:<12} {}: {}\n", step.number, step.name, word, step.text);
    if (found == results_.end()) continue;
    for (const Finding& finding : found->second.findings) fmt::format_to(out, "      ! {}\n", finding.text);
    for (const std::string& note : found->second.notes) fmt::format_to(out, "      {}\n", note);
    for (const Measure& measure : found->second.measures) {
      const std::string given =
          std::isnan(measure.given) ? "not given" : fmt::format("{:.4g}", measure.given);
      fmt::format_to(out, "      {:<8} {:<24} {:>10.4g} +- {:<8.2g} given {}\n",
                     measure.axis < 0 ? "arm" : file_->axes[static_cast<std::size_t>(measure.axis)].name,
                     measure.name, measure.value, measure.spread, given);
    }
  }
  return text;
}

std::string Commission::state() const {
  Json all{
      {"thimble_commission", 1}, {"name", name_}, {"by", by_}, {"arm", arm_}, {"known", json_of(known_)}};
  Json done = Json::object();
  for (const auto& [number, result] : results_) done[std::to_string(number)] = json_of(result);
  all["steps"] = done;
  return all.dump(2) + "\n";
}

Commission Commission::from_state(const std::string& text) {
  try {
    const Json all = Json::parse(text);
    if (all.at("thimble_commission") != 1) throw std::invalid_argument("version of the state");
    Commission commission(all.at("arm").dump(2), all.at("name"), all.at("by"));
    commission.known_ = known_of(all.at("known"));
    for (const auto& [number, result] : all.at("steps").items())
      commission.results_[std::stoi(number)] = result_of(result);
    return commission;
  } catch (const std::logic_error& error) {
    throw Error(ExitCode::kBadInput, "bad-state",
                std::string("the saved commissioning cannot be read: ") + error.what(),
                "begin the commissioning anew");
  } catch (const Json::exception& error) {
    throw Error(ExitCode::kBadInput, "bad-state",
                std::string("the saved commissioning cannot be read: ") + error.what(),
                "begin the commissioning anew");
  }
}

void Commission::save(const std::filesystem::path& file) const {
  OutputFile output(file);
  output.stream() << state();
  output.commit();
}

}  // namespace thimble::host
