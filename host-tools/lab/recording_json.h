// A recording and its replay as JSON: what `thimble record` and `thimble replay` print, and what a page shows.
#pragma once

#include <nlohmann/json.hpp>

#include "host-tools/lab/recording.h"
#include "host-tools/lab/replay_recording.h"

namespace thimble::host {

[[nodiscard]] nlohmann::ordered_json verdict_json(const ReplayVerdict& verdict);
[[nodiscard]] nlohmann::ordered_json about_json(const Recording& recording);

}  // namespace thimble::host
