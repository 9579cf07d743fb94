#include "board/zynqmp/watchdog.h"

#include "board/zynqmp/registers.h"

namespace thimble::board {
namespace {

constexpr std::uint32_t kModeKey = 0xABCU << 12U, kControlKey = 0x248U << 14U, kRestartKey = 0x1999;
constexpr std::uint32_t kOn = 1U << 0U, kResetsSystem = 1U << 1U, kLongPulse = 3U << 4U;  // of mode
constexpr std::uint32_t kBy64 = 1;                                                        // of control
constexpr std::uint32_t kStep = 4096;  // unit of the reload value

volatile WatchdogRegisters& registers() noexcept { return at<WatchdogRegisters>(kSwdt0); }

}  // namespace

void start_watchdog(std::uint32_t clock_Hz, std::uint32_t limit_ms) noexcept {
  const std::uint32_t counts = clock_Hz / 64 / 1000 * limit_ms;
  stop_watchdog();  // it must be off while it is changed
  registers().control = kControlKey | ((counts / kStep + 1) & 0xFFFU) << 2U | kBy64;
  registers().mode = kModeKey | kOn | kResetsSystem | kLongPulse;
  feed_watchdog();
}

void stop_watchdog() noexcept { registers().mode = kModeKey; }

void feed_watchdog() noexcept { registers().restart = kRestartKey; }

}  // namespace thimble::board
