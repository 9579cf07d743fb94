// Results of a commissioning as JSON and back. NaN is null. The readers throw nlohmann::json::exception or std::out_of_range.
#pragma once

#include <nlohmann/json.hpp>

#include "host-tools/commission/steps.h"

namespace thimble::host {

[[nodiscard]] nlohmann::ordered_json json_of(const StepResult& result);
[[nodiscard]] nlohmann::ordered_json json_of(const Known& known);
[[nodiscard]] StepResult result_of(const nlohmann::ordered_json& json);
[[nodiscard]] Known known_of(const nlohmann::ordered_json& json);

}  // namespace thimble::host
