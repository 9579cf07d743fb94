// Where an axis stays when it is let go.
#pragma once

#include <cstdint>

#include "host-tools/commission/steps.h"

namespace thimble::host {

// By the weights of the file; where it has none, by trials: the builder lets the axis go, and which way it falls says where to try next. The place is
// kept for later steps. Where none is found, or the builder stops, the place with which the search began.
[[nodiscard]] board::JointVector resting_place(StepContext& context, std::size_t axis);

// Whether it stays there: by the weights of the file where they turn it less than half of its friction, else by a trial.
enum class Rest : std::uint8_t { kStays, kFalls, kStopped };
[[nodiscard]] Rest rest_of(StepContext& context, std::size_t axis);

}  // namespace thimble::host
