#include "host-tools/commission/procedure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/commissioned.h"
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

int step_of(const std::string& number) {
  const int step = std::stoi(number);
  if (step < 0 || step >= static_cast<int>(steps().size())) throw std::out_of_range("step " + number);
  return step;
}

[[noreturn]] void refuse_state(const std::string& why) {
  throw Error(ExitCode::kBadInput, "bad-state", "is a damaged commissioning: " + why,
              "begin the commissioning anew");
}

constexpr int kStepOfCurrents = 4;
constexpr const char* kWalls = "/limits/largest_walls";

// With the margin, in place of those of the same rate.
void write_walls(Json& arm, const std::vector<const Measure*>& measured, const std::string& by) {
  if (measured.empty()) return;
  Json walls = Json::array();
  if (const Json::json_pointer place(kWalls); arm.contains(place))
    for (const Json& wall : arm.at(place))
      if (std::abs(wall.at("rate_Hz").get<double>() - measured.front()->rate_Hz) > .5) walls.push_back(wall);
  for (const Measure* measure : measured)
    walls.push_back({{"rate_Hz", measure->rate_Hz},
                     {"damping_N_s_m", measure->damping_N_s_m},
                     {"stiffness_N_m",
                      {{"value", rounded(kWallMargin * measure->value)},
                       {"spread", rounded(kWallMargin * measure->spread)},
                       {"by", by}}}});
  arm[Json::json_pointer(kWalls)] = walls;
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
  given_ = Json::parse(arm_text);
  arm_ = given_;
  reread();
}

bool Commission::is_of(const std::string& arm_text) const { return given_ == Json::parse(arm_text); }

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
  if (needs_place(number, bench))
    throw Error(ExitCode::kRefused, "step-order", "the counters have begun anew since step 2",
                "do step 2 again");
  bench.use(*file_);
  if (step.needs_place) bench.locate(known_.at_zero);
  StepContext context{bench, *expectation_, known_};
  const Known before = known_;
  StepResult result;
  try {
    result = step.run(context);
  } catch (...) {
    known_ = before;
    throw;
  }
  // What later steps found of another arm, or of this one before it was repaired, is void.
  if (!result.passed) results_.erase(results_.upper_bound(number), results_.end());
  if (std::ranges::any_of(result.findings, [](const ArmFinding& found) {
        return found.fault == ArmFault::kMotorsSwapped || found.fault == ArmFault::kJointsSwapped;
      }))
    results_.erase(kStepOfCurrents);  // it looked at the motors of other joints
  StepResult& kept = results_[number] = std::move(result);
  accept(kept, bench);
  return kept;
}

void Commission::accept(StepResult& result, Bench& bench) {
  for (std::size_t i = 0; i < result.findings.size(); ++i) {
    const ArmFinding& found = result.findings[i];
    if (found.corrections.empty()) continue;
    Prompt asked = prompt(Prompt::Kind::kAcceptCorrection, static_cast<std::size_t>(std::max(0, found.axis)),
                          found.text + " Is the arm right as it is, and the file wrong?");
    asked.finding = i;
    if (bench.ask(asked) == Answer::kDone && correct(found, result.notes))
      corrections_.insert(corrections_.end(), found.corrections.begin(), found.corrections.end());
  }
}

bool Commission::correct(const ArmFinding& found, std::vector<std::string>& notes) {
  const Json before = arm_;
  for (const Correction& correction : found.corrections) {
    own_motor(arm_, correction.pointer);
    Json& value = arm_[Json::json_pointer(correction.pointer)];
    if (correction.value == std::trunc(correction.value) && std::abs(correction.value) < 1e9) {
      value = static_cast<std::int64_t>(correction.value);
    } else {
      value = {{"value", rounded(correction.value)}, {"by", by_}};
    }
  }
  try {
    static_cast<void>(check_arm(read_arm_file(arm_.dump(2), name_), name_));
  } catch (const Error& error) {
    notes.push_back(
        fmt::format("Not corrected, because the file would be refused: {}; {}", error.cause, error.remedy));
    arm_ = before;
    return false;
  }
  reread();
  return true;
}

bool Commission::passed(int number) const {
  const auto found = results_.find(number);
  return found != results_.end() && found->second.passed;
}

bool Commission::needs_place(int number, Bench& bench) const {
  return steps()[static_cast<std::size_t>(number)].needs_place && known_.session != bench.facts().session;
}

int Commission::next() const {
  int number = 0;
  while (number < static_cast<int>(steps().size()) && passed(number)) ++number;
  return number;
}

std::string place_of(const Measure& measure) {
  if (!(measure.value >= 0)) return {};
  if (!(measure.spread <= measure.promise * std::abs(measure.value))) return {};
  if (measure.axis < 0) return measure.name == "largest_wall_N_m" ? kWalls : "";
  for (const ResultPlace& place : kResultPlaces)
    if (measure.name == place.measure) return fmt::format("/axes/{}/{}", measure.axis, place.key);
  return {};
}

// Where the given file has no friction: a part that is too small to be measured is written as it was seen, and without the largest part none.
void Commission::complete_friction(Json& arm) const {
  for (std::size_t j = 0; j < arm.at("axes").size(); ++j) {
    Json& axis = arm["axes"][j];
    if (!axis.contains("friction")) continue;
    Json& friction = axis["friction"];
    if (!friction.contains("coulomb_N_m")) {
      axis.erase("friction");
    } else if (!friction.contains("viscous_N_m_s_rad")) {
      friction["viscous_N_m_s_rad"] = 0;
      for (const auto& [number, result] : results_)
        for (const Measure& measure : result.measures)
          if (measure.name == "viscous_N_m_s_rad" && measure.axis == static_cast<int>(j))
            friction["viscous_N_m_s_rad"] = {{"value", rounded(std::max(0.0, measure.value))},
                                             {"spread", rounded(measure.spread)},
                                             {"by", by_}};
    }
  }
}

std::string Commission::arm_file(const std::string& proved_on) const {
  Json arm = arm_;
  std::vector<const Measure*> walls;
  for (const auto& [number, result] : results_) {
    for (const Measure& measure : result.measures) {
      const std::string pointer = place_of(measure);
      if (pointer.empty()) continue;
      if (pointer == kWalls) {
        walls.push_back(&measure);
        continue;
      }
      own_motor(arm, pointer);
      arm[Json::json_pointer(pointer)] = {
          {"value", rounded(measure.value)}, {"spread", rounded(measure.spread)}, {"by", by_}};
    }
  }
  complete_friction(arm);
  write_walls(arm, walls, by_);
  drop_unused_motors(arm);
  arm.erase(kCommissionedKey);
  if (!proved_on.empty()) arm[kCommissionedKey] = {{"on", proved_on}, {"crc32", commissioned_crc(arm)}};
  return arm.dump(2) + "\n";
}

std::string Commission::state() const {
  Json all{{"thimble_commission", 1}, {"name", name_}, {"by", by_},
           {"given", given_},         {"arm", arm_},   {"bench", bench_},
           {"known", json_of(known_)}};
  Json corrections = Json::array();
  for (const Correction& correction : corrections_) corrections.push_back(json_of(correction));
  all["corrections"] = corrections;
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
    commission.given_ = all.at("given");
    commission.bench_ = all.at("bench");
    for (const Json& correction : all.at("corrections"))
      commission.corrections_.push_back(correction_of(correction));
    commission.known_ = known_of(all.at("known"));
    for (const auto& [number, result] : all.at("steps").items())
      commission.results_[step_of(number)] = result_of(result);
    commission.demand_axes();
    return commission;
  } catch (const std::logic_error& error) {
    refuse_state(error.what());
  } catch (const Json::exception& error) {
    refuse_state(error.what());
  } catch (const Error& error) {  // of the arm in it, which is not the user's file
    refuse_state(error.cause);
  }
}

void Commission::demand_axes() const {
  const auto demand = [this](int axis) {
    if (axis < -1 || axis >= static_cast<int>(file_->axes.size()))
      throw std::out_of_range("axis " + std::to_string(axis));
  };
  for (const auto& [number, result] : results_) {
    for (const Measure& measure : result.measures) demand(measure.axis);
    for (const ArmFinding& found : result.findings) {
      demand(found.axis);
      demand(found.other);
    }
  }
}

void Commission::save(const std::filesystem::path& file) const {
  OutputFile output(file);
  output.stream() << state();
  output.commit();
}

}  // namespace thimble::host
