// Results of a commissioning as JSON and back. NaN is null. The readers throw nlohmann::json::exception or std::out_of_range.
#pragma once

#include <nlohmann/json.hpp>

#include "host-tools/commission/steps.h"

namespace thimble::host {

[[nodiscard]] nlohmann::ordered_json json_of(const StepResult& result);
[[nodiscard]] nlohmann::ordered_json json_of(const Known& known);
[[nodiscard]] nlohmann::ordered_json json_of(const Correction& correction);
[[nodiscard]] nlohmann::ordered_json json_of(const ArmFinding& found);
[[nodiscard]] nlohmann::ordered_json json_of(const Measure& measure);
[[nodiscard]] Correction correction_of(const nlohmann::ordered_json& json);
[[nodiscard]] StepResult result_of(const nlohmann::ordered_json& json);
[[nodiscard]] Known known_of(const nlohmann::ordered_json& json);

}  // namespace thimble::host
