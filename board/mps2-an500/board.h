// This board's choices: what somebody who builds a device with it changes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace thimble::board {

inline constexpr std::uint32_t kRate_Hz = 4000;
inline constexpr std::uint8_t kArms = 1;
inline constexpr const char* kArmModel = "premium-1.5";
inline constexpr std::uint8_t kNode = 1;

// The register block of encoders and currents (board/cortex/fabric.h), in the last page of the PSRAM.
inline constexpr std::uintptr_t kFabric = 0x60FFF000;
inline constexpr std::uint32_t kFabricWatchdog_us = 2000;

// Of an upload, at once: the EEPROM takes 25 ms for it.
inline constexpr std::uint16_t kBlockBytes = 512;

// Without a tick, a round of the link or of the background for so long the board starts anew, the motors off.
inline constexpr std::uint32_t kTickLimit_us = 10'000;
inline constexpr std::uint32_t kBackgroundLimit_us = 1'000'000;
inline constexpr std::uint32_t kWatchdog_ms =
    100;  // until its interrupt; the reset comes after as long again

}  // namespace thimble::board
