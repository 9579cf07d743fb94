// Settings of this board, to be adapted for a device.
#pragma once

#include <cstddef>
#include <cstdint>

namespace thimble::board {

inline constexpr std::uint32_t kRate_Hz =
    THIMBLE_RATE_HZ;  // of the tick, 1000 to 20000: a setting of the build
inline constexpr std::uint8_t kArms = 1;
inline constexpr const char* kArmModel = "premium-1.5";
inline constexpr std::uint8_t kNode = 1;

// The register block of encoders and currents (board/cortex/fabric.h), in the last page of the PSRAM.
inline constexpr std::uintptr_t kFabric = 0x60FFF000;

// Block size of an upload: the EEPROM needs 25 ms for it.
inline constexpr std::uint16_t kBlockBytes = 512;

// After this time without a tick, or without a cycle of the link or background, the watchdog is not fed any
// more: the motors go off after the time of firmware/core/stop_timeout.h, and the board restarts after
// kWatchdog_ms.
inline constexpr std::uint32_t kTickLimit_us = 10'000;
inline constexpr std::uint32_t kBackgroundLimit_us = 1'000'000;
inline constexpr std::uint32_t kWatchdog_ms = 100;

}  // namespace thimble::board
