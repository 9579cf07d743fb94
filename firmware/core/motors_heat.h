// The heat of all motors, as it travels between the tick and what must survive a restart (firmware/store/persistent_state.h).
#pragma once

#include <array>

#include "firmware/core/config.h"
#include "firmware/exchange/snapshot.h"
#include "firmware/exchange/word.h"

namespace thimble::firmware {

// Above ambient.
struct Heat {
  float winding_K = 0;
  float housing_K = 0;
};
using MotorsHeat = std::array<std::array<Heat, kJoints>, kMaxArms>;

struct HeatExchange {
  static constexpr float kInterval_s = 0.1F;

  Snapshot<MotorsHeat> now;  // from the tick, every kInterval_s
  Snapshot<MotorsHeat>
      less;  // to the tick: take this off, once, because the board has learned how long it was off
  Value<bool>
      not_kept;  // to the tick: the store did not take the newest record, so a restart would forget it
};

}  // namespace thimble::firmware
