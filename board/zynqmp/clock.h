// Time since start, and the tick's times, from the processor's cycle counter (PMCCNTR, Cortex-R5 Technical Reference Manual chapter
// 6). No interrupt: the loop asks. The servo's calls may come in between the background's, as Config::pause has it, and not the other
// way round.
//
// Not from a triple timer counter: reading one takes a way over two buses, QEMU's has 16 bits instead of 32, and when QEMU counts
// instructions it hangs where that counter wraps (7.2).
#pragma once

#include <cstdint>

#include "board/cortex/tick.h"
#include "firmware/link/can_frame.h"

namespace thimble::board::clock {

// The counts of a clock in microseconds; no product overflows before the result does.
[[nodiscard]] constexpr std::uint64_t to_micros(std::uint64_t counts, std::uint32_t hertz) noexcept {
  return counts / hertz * 1'000'000U + counts % hertz * 1'000'000U / hertz;
}

void start(std::uint32_t clock_Hz) noexcept;       // time begins
void start_ticks(std::uint32_t rate_Hz) noexcept;  // the first tick is due one period later

// Some microseconds in which nothing is asked of any device, or less where a tick comes due: a FIFO of 64 bytes at 921600 baud
// fills in 690.
void rest() noexcept;

[[nodiscard]] firmware::link::Micros now_us() noexcept;  // asked at least once in 4 s, or time is lost

// --- servo
[[nodiscard]] bool tick_due() noexcept;
[[nodiscard]] TickTime begin_tick() noexcept;  // once a tick that is due
[[nodiscard]] float since_begin_us() noexcept;

}  // namespace thimble::board::clock
