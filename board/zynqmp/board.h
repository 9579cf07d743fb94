// This board's choices: what somebody who builds a device with it changes.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {  // Absolute symbols of the linker (CMakeLists.txt), whose addresses are the values: QEMU differs in these two.
extern const char board_fabric[];   // the register block of encoders and currents (board/cortex/fabric.h)
extern const char board_core_Hz[];  // the processor's clock: CRL_APB.CPU_R5_CTRL
}

namespace thimble::board {

inline constexpr std::uint32_t kRate_Hz = 4000;
inline constexpr std::uint8_t kArms = 1;
inline constexpr const char* kArmModel = "premium-1.5";
inline constexpr std::uint8_t kNode = 1;

inline constexpr std::uint32_t kCanBitrate = 1'000'000;
inline constexpr std::uint32_t kCanClock_Hz = 100'000'000;  // CRL_APB.CAN0_REF_CTRL
inline constexpr std::uint32_t kUartBaud = 921'600;
inline constexpr std::uint32_t kUartClock_Hz = 100'000'000;  // CRL_APB.UART1_REF_CTRL

// Where the slots begin in the flash. Boot images lie below, in a chip of 64 MiB.
inline constexpr std::uint32_t kStore = 48U << 20U;
inline constexpr std::size_t kSceneSlotBytes = std::size_t{4} << 20U;

inline constexpr std::uint32_t kFabricWatchdog_us = 2000;
// Without a tick, a round of the link or of the background for so long the board starts anew, the motors off. The
// background may wait for the flash to erase 64 KiB: 1 s by its data sheet.
inline constexpr std::uint32_t kTickLimit_us = 10'000;
inline constexpr std::uint32_t kBackgroundLimit_us = 2'000'000;
inline constexpr std::uint32_t kWatchdog_ms = 100;
inline constexpr std::uint32_t kLsbusClock_Hz = 100'000'000;  // CRL_APB.LPD_LSBUS_CTRL, of the watchdog

}  // namespace thimble::board
