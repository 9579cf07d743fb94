#include "host-tools/commission/state.h"

#include <cmath>
#include <limits>

namespace thimble::host {
namespace {

using StateJson = nlohmann::ordered_json;

double number_of(const StateJson& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

ArmFinding finding_of(const StateJson& json) {
  ArmFinding found;
  found.fault = fault_named(json.at("fault").get<std::string>());
  found.axis = json.at("axis");
  found.other = json.at("other");
  found.factor = number_of(json.at("factor"));
  for (const StateJson& twin : json.at("twins")) found.twins.push_back(fault_named(twin.get<std::string>()));
  for (const StateJson& correction : json.at("corrections"))
    found.corrections.push_back(correction_of(correction));
  found.text = json.at("text");
  return found;
}

}  // namespace

StateJson json_of(const Correction& correction) {
  return {{"pointer", correction.pointer}, {"value", correction.value}};
}

Correction correction_of(const StateJson& json) { return {json.at("pointer"), json.at("value")}; }

StateJson json_of(const ArmFinding& found) {
  StateJson twins = StateJson::array(), corrections = StateJson::array();
  for (const ArmFault twin : found.twins) twins.push_back(text_of(twin).name);
  for (const Correction& correction : found.corrections) corrections.push_back(json_of(correction));
  return {{"fault", text_of(found.fault).name},
          {"axis", found.axis},
          {"other", found.other},
          {"factor", found.factor},
          {"twins", twins},
          {"corrections", corrections},
          {"text", found.text}};
}

StateJson json_of(const Measure& measure) {
  return {
      {"name", measure.name},       {"axis", measure.axis},       {"given", measure.given},
      {"value", measure.value},     {"spread", measure.spread},   {"residual", measure.residual},
      {"promise", measure.promise}, {"rate_Hz", measure.rate_Hz}, {"damping_N_s_m", measure.damping_N_s_m}};
}

StateJson json_of(const StepResult& result) {
  StateJson findings = StateJson::array(), measures = StateJson::array();
  for (const ArmFinding& found : result.findings) findings.push_back(json_of(found));
  for (const Measure& m : result.measures) measures.push_back(json_of(m));
  return {{"passed", result.passed},
          {"stopped", result.stopped},
          {"findings", findings},
          {"measures", measures},
          {"notes", result.notes}};
}

StateJson json_of(const Known& known) {
  return {{"session", known.session},
          {"at_zero", known.at_zero},
          {"torque_constant_N_m_A", known.torque_constant_N_m_A},
          {"has_torque_scale", known.has_torque_scale}};
}

StepResult result_of(const StateJson& json) {
  StepResult result;
  result.passed = json.at("passed");
  result.stopped = json.at("stopped");
  for (const StateJson& found : json.at("findings")) result.findings.push_back(finding_of(found));
  for (const StateJson& m : json.at("measures"))
    result.measures.push_back({m.at("name"), m.at("axis"), number_of(m.at("given")), number_of(m.at("value")),
                               number_of(m.at("spread")), number_of(m.at("residual")),
                               number_of(m.at("promise")), number_of(m.at("rate_Hz")),
                               number_of(m.at("damping_N_s_m"))});
  result.notes = json.at("notes").get<std::vector<std::string>>();
  return result;
}

Known known_of(const StateJson& json) {
  Known known;
  known.session = json.at("session");
  known.at_zero = json.at("at_zero").get<PerAxis<double>>();
  known.torque_constant_N_m_A = json.at("torque_constant_N_m_A").get<PerAxis<double>>();
  known.has_torque_scale = json.at("has_torque_scale").get<PerAxis<bool>>();
  return known;
}

}  // namespace thimble::host
