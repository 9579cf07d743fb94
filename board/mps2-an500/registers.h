// The registers that this board uses: Cortex-M7 (ARMv7-M Architecture Reference Manual) and the CMSDK
// peripherals of the MPS2+ FPGA board (application note 385 and 500; CMSDK Technical Reference Manual).
#pragma once

#include <cstdint>

#include "board/cortex/mmio.h"

namespace thimble::board {

inline constexpr std::uint32_t kClock_Hz = 25'000'000;  // of the core and of all below

// --- the core
struct SysTickRegisters {
  std::uint32_t control;  // bit 0 on, bit 1 interrupt, bit 2 use the core clock
  std::uint32_t load;
  std::uint32_t value;
};
inline constexpr std::uintptr_t kSysTick = 0xE000E010;
inline constexpr std::uintptr_t kInterruptEnable = 0xE000E100;    // NVIC_ISER0
inline constexpr std::uintptr_t kInterruptPriority = 0xE000E400;  // NVIC_IPR, one byte per interrupt
inline constexpr std::uintptr_t kSysTickPriority = 0xE000ED23;    // of SHPR3
inline constexpr std::uintptr_t kCoprocessors = 0xE000ED88;       // CPACR
inline constexpr std::uintptr_t kResetControl = 0xE000ED0C;       // AIRCR
inline constexpr std::uint32_t kResetRequest = 0x05FA0004;        // key, SYSRESETREQ

// --- CMSDK
struct UartRegisters {
  std::uint32_t data;
  std::uint32_t state;       // bit 0 transmitter full, bit 1 receiver full, bits 2, 3 overrun
  std::uint32_t control;     // bits 0, 1 transmitter and receiver on; bits 2, 3 their interrupts
  std::uint32_t interrupts;  // bits 0, 1 transmitter and receiver; write 1 to clear
  std::uint32_t divider;
};
inline constexpr std::uintptr_t kUart0 = 0x40004000;
inline constexpr unsigned kUart0ReceiveInterrupt = 0;
inline constexpr unsigned kUart0TransmitInterrupt = 1;

struct TimerRegisters {  // one half of a dual timer
  std::uint32_t load;
  std::uint32_t value;    // counts down
  std::uint32_t control;  // bit 7 on, bit 1 of 32 bits
};
inline constexpr std::uintptr_t kDualTimer = 0x40002000;

struct WatchdogRegisters {
  std::uint32_t load;
  std::uint32_t value;
  std::uint32_t control;  // bit 0 interrupt (NMI) at the first time-out, bit 1 reset at the second
  std::uint32_t clear;    // any write: restarts it
};
inline constexpr std::uintptr_t kWatchdogUnit = 0x40008000;
inline constexpr std::uintptr_t kWatchdogLock = 0x40008C00;
inline constexpr std::uint32_t kWatchdogKey = 0x1ACCE551;

struct I2cRegisters {   // two lines, driven by software (ARM SBCon)
  std::uint32_t set;    // read: bit 0 clock, bit 1 data; write: release a line
  std::uint32_t clear;  // write: pull a line low
};
inline constexpr std::uintptr_t kShield1I2c = 0x4002A000;

}  // namespace thimble::board
