// Time since start, and the times of the tick, from the processor's cycle counter (PMCCNTR, Cortex-R5
// Technical Reference Manual chapter 6). Polled, no interrupt. Calls of the tick context may interrupt those
// of the background (Config::pause), never the other way round.
//
// A triple timer counter is not used: reading it crosses two buses, QEMU's has 16 bits instead of 32, and
// with instruction counting QEMU 7.2 hangs when that counter wraps.
#pragma once

#include <cstdint>

#include "board/cortex/tick.h"
#include "firmware/link/can_frame.h"

namespace thimble::board::clock {

// Converts clock counts to microseconds; no intermediate product overflows before the result does.
[[nodiscard]] constexpr std::uint64_t to_micros(std::uint64_t counts, std::uint32_t hertz) noexcept {
  return counts / hertz * 1'000'000U + counts % hertz * 1'000'000U / hertz;
}

void start(std::uint32_t clock_Hz) noexcept;       // sets the time to 0
void start_ticks(std::uint32_t rate_Hz) noexcept;  // the first tick is due one period later

// Waits for some microseconds without device access, or until a tick is due. For comparison: a FIFO of 64
// bytes at 921600 baud fills in 690 us.
void rest() noexcept;

[[nodiscard]] firmware::link::Micros
now_us() noexcept;  // call it at least once in 4 s, otherwise the counter wraps

// --- servo
[[nodiscard]] bool tick_due() noexcept;
[[nodiscard]] TickTime begin_tick() noexcept;  // once per due tick
[[nodiscard]] float since_begin_us() noexcept;

}  // namespace thimble::board::clock
