// One tick of a board whose arm is connected to the register block (fabric.h), in the tick context.
#pragma once

#include <cstdint>

#include "board/cortex/fabric.h"
#include "firmware/controller.h"

namespace thimble::board {

struct TickTime {
  std::uint64_t tick = 0;  // periods since the first tick
  std::uint64_t time_us = 0;
  float late_us = 0;  // delay of the tick against its nominal time
};

// Reads encoders and lines, runs the controller, writes currents. last_tick_us: duration of the previous
// tick.
template <class Drives>  // Fabric, or a board's class around it
void run_tick(Drives& fabric, firmware::Controller& controller, const TickTime& time,
              float last_tick_us) noexcept {
  firmware::Inputs inputs;
  inputs.tick = time.tick;
  inputs.time_us = time.time_us;
  inputs.late_us = time.late_us;
  inputs.last_tick_us = last_tick_us;
  fabric.latch(inputs);
  fabric.commit(controller.tick(inputs));
}

}  // namespace thimble::board
