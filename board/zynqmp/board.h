// Settings of this board, to be adapted for a device.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {  // Absolute linker symbols (CMakeLists.txt); their addresses are the values. The image for QEMU has other values.
extern const char board_fabric[];   // the register block of encoders and currents (board/cortex/fabric.h)
extern const char board_core_Hz[];  // processor clock: CRL_APB.CPU_R5_CTRL
}

namespace thimble::board {

inline constexpr std::uint32_t kRate_Hz =
    THIMBLE_RATE_HZ;  // of the tick, 1000 to 20000: a setting of the build
inline constexpr std::uint8_t kArms = 1;
inline constexpr const char* kArmModel = "premium-1.5";
inline constexpr std::uint8_t kNode = 1;

inline constexpr std::uint32_t kCanBitrate = 1'000'000;
inline constexpr std::uint32_t kCanClock_Hz = 100'000'000;  // CRL_APB.CAN0_REF_CTRL
inline constexpr std::uint32_t kUartBaud = 921'600;
inline constexpr std::uint32_t kUartClock_Hz = 100'000'000;  // CRL_APB.UART1_REF_CTRL

// Start of the slots in the flash, a chip of 64 MiB. Boot images are below.
inline constexpr std::uint32_t kStore = 48U << 20U;
inline constexpr std::size_t kSceneSlotBytes = std::size_t{4} << 20U;

// The board restarts with motors off after this time without a tick, or without a cycle of the link or
// background. The background may wait until the flash has erased 64 KiB: at most 1 s by its data sheet.
inline constexpr std::uint32_t kTickLimit_us = 10'000;
inline constexpr std::uint32_t kBackgroundLimit_us = 2'000'000;
inline constexpr std::uint32_t kWatchdog_ms = 100;
inline constexpr std::uint32_t kLsbusClock_Hz = 100'000'000;  // CRL_APB.LPD_LSBUS_CTRL, clock of the watchdog

}  // namespace thimble::board
