// The events and trials of a recording as a table of their own: tick, time, kind and code. What `thimble replay --events` writes.
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>

#include "host-tools/lab/recording.h"

namespace thimble::host {

// Since the recording began, as the rows of a replay count.
[[nodiscard]] double time_of(const Recording& recording, const RecordedMark& mark);

[[nodiscard]] nlohmann::ordered_json events_json(
    const Recording& recording);  // a list of {tick, time_s, kind, code}
void write_events_csv(std::ostream& out, const Recording& recording);

}  // namespace thimble::host
