// What a tick may still do, and the bounds that it has met.
#pragma once

#include "control/renderer_types.h"
#include "control/work.h"

namespace thimble::control {

struct Effort {
  Work work{};
  RenderCounters counters;  // since bind()
};

}  // namespace thimble::control
