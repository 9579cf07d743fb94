// Time since start, and the tick's interrupt: a free-running timer beside the SysTick, so that a lost tick is seen.
#pragma once

#include <cstdint>

namespace thimble::board::clock {

void start(std::uint32_t rate_Hz) noexcept;  // the first tick's interrupt comes one period later

// The tick's context.
struct TickTime {
  std::uint64_t tick = 0;  // periods since start
  std::uint64_t time_us = 0;
  float late_us = 0;  // of now against the tick's time
};
[[nodiscard]] TickTime begin_tick() noexcept;
[[nodiscard]] float since_begin_us() noexcept;

[[nodiscard]] std::uint64_t now_us() noexcept;  // background

}  // namespace thimble::board::clock
