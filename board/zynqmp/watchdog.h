// The system watchdog timer of the low-power domain (SWDT0, UG1085 chapter 14): if it is not fed in time, it
// reports an error to the platform management unit, which resets the system as configured in its firmware.
// QEMU does not model this device.
#pragma once

#include <cstdint>

namespace thimble::board {

void start_watchdog(std::uint32_t clock_Hz, std::uint32_t limit_ms) noexcept;  // up to 10 s
void feed_watchdog() noexcept;
void stop_watchdog() noexcept;

}  // namespace thimble::board
