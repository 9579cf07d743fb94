#include "board/zynqmp/clock.h"

namespace thimble::board::clock {
namespace {

constexpr std::uint32_t kRests = 16, kTurns = 200;  // one iteration takes two or three cycles

std::uint32_t hertz = 1;
std::uint64_t counts = 0;  // since start()
std::uint64_t first = 0;   // start_ticks()
std::uint32_t period = 0;  // counts; 0: no ticks yet
std::uint64_t due = 0;
std::uint64_t begin = 0;  // of the last tick

std::uint64_t read() noexcept {
  std::uint32_t cycles = 0;
  asm volatile("mrc p15, 0, %0, c9, c13, 0" : "=r"(cycles));  // PMCCNTR
  counts += cycles - static_cast<std::uint32_t>(counts);      // modulo 2^32, like the counter
  return counts;
}

// Of a tick or two: to make a float of 64 bits takes the compiler's library of software floats.
float to_us(std::uint32_t difference) noexcept {
  return static_cast<float>(difference) * (1e6F / static_cast<float>(hertz));
}

}  // namespace

void start(std::uint32_t clock_Hz) noexcept {
  hertz = clock_Hz;
  asm volatile("mcr p15, 0, %0, c9, c12, 0" ::"r"(1U << 0U |
                                                  1U << 2U));   // PMCR: counters on, the cycle counter from 0
  asm volatile("mcr p15, 0, %0, c9, c12, 1" ::"r"(1U << 31U));  // PMCNTENSET: the cycle counter
}

void start_ticks(std::uint32_t rate_Hz) noexcept {
  first = read();
  period = (hertz + rate_Hz / 2) / rate_Hz;
  due = first + period;
}

void rest() noexcept {
  asm volatile("yield");  // no effect on the chip; QEMU switches to the next core when it runs them in turn
  for (std::uint32_t i = 0; i < kRests && !tick_due(); ++i) {
    for (std::uint32_t turn = 0; turn < kTurns; ++turn) asm volatile("");
  }
}

firmware::link::Micros now_us() noexcept { return to_micros(read(), hertz); }

bool tick_due() noexcept { return period != 0 && read() >= due; }

TickTime begin_tick() noexcept {
  begin = read();
  const std::uint64_t since = begin - first;
  const std::uint64_t tick = since / period;
  due = first + (tick + 1) * period;
  return {tick, to_micros(begin, hertz), to_us(static_cast<std::uint32_t>(since % period))};
}

float since_begin_us() noexcept { return to_us(static_cast<std::uint32_t>(read() - begin)); }

}  // namespace thimble::board::clock
