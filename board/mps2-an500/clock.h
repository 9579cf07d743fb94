// Time since start, and the interrupt of the tick. A free-running timer, independent of the SysTick, detects
// lost ticks.
#pragma once

#include <cstdint>

#include "board/cortex/tick.h"

namespace thimble::board::clock {

void start(std::uint32_t rate_Hz) noexcept;  // the first tick interrupt follows one period later

// The tick's context.
[[nodiscard]] TickTime begin_tick() noexcept;
[[nodiscard]] float since_begin_us() noexcept;

[[nodiscard]] std::uint64_t now_us() noexcept;  // background

}  // namespace thimble::board::clock
