#include "board/mps2-an500/clock.h"

#include "board/mps2-an500/registers.h"

namespace thimble::board::clock {
namespace {

constexpr std::uint32_t kCyclesPerUs = kClock_Hz / 1'000'000;
constexpr std::uint32_t kTimerOn = 1U << 7U | 1U << 1U;
constexpr std::uint32_t kSysTickOn = 7;

std::uint32_t period = 0;   // cycles
std::uint64_t cycles = 0;   // until the last tick; written by the tick
std::uint32_t at_last = 0;  // timer value at that time

std::uint32_t timer() noexcept { return ~at<TimerRegisters>(kDualTimer).value; }

}  // namespace

void start(std::uint32_t rate_Hz) noexcept {
  period = (kClock_Hz + rate_Hz / 2) / rate_Hz;
  at<TimerRegisters>(kDualTimer).load = 0xFFFFFFFF;
  at<TimerRegisters>(kDualTimer).control = kTimerOn;
  at<std::uint8_t>(kSysTickPriority) = 0;  // highest priority
  volatile SysTickRegisters& tick = at<SysTickRegisters>(kSysTick);
  tick.load = period - 1;
  at_last = timer();
  tick.value = 0;
  tick.control = kSysTickOn;
}

TickTime begin_tick() noexcept {
  const std::uint32_t now = timer();
  cycles += now - at_last;  // the timer wraps after 171 s; the next tick is earlier
  at_last = now;
  return {cycles / period, cycles / kCyclesPerUs,
          static_cast<float>(static_cast<std::uint32_t>(cycles % period)) / static_cast<float>(kCyclesPerUs)};
}

float since_begin_us() noexcept {
  return static_cast<float>(timer() - at_last) / static_cast<float>(kCyclesPerUs);
}

// Reads again if a tick came in between.
std::uint64_t now_us() noexcept {
  const volatile std::uint32_t& last = at_last;
  for (;;) {
    const std::uint32_t before = last;
    asm volatile("" ::: "memory");
    const std::uint64_t now = cycles + (timer() - before);
    asm volatile("" ::: "memory");
    if (last == before) return now / kCyclesPerUs;
  }
}

}  // namespace thimble::board::clock
