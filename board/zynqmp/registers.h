// The registers that this board uses, by the names of the Zynq UltraScale+ Technical Reference Manual
// (UG1085) and register reference (UG1087). Drivers take a struct by reference, so that a test on the PC can
// pass one in memory.
#pragma once

#include <cstdint>

#include "board/cortex/mmio.h"

namespace thimble::board {

struct CanRegisters {
  struct Frame {
    std::uint32_t id, dlc, data1, data2;
  };
  std::uint32_t srr;  // software reset
  std::uint32_t msr;  // mode select
  std::uint32_t brpr;
  std::uint32_t btr;
  std::uint32_t ecr;  // error counters: receive << 8 | transmit
  std::uint32_t esr;  // error status
  std::uint32_t sr;   // status
  std::uint32_t isr, ier, icr;
  std::uint32_t tcr;  // timestamps
  std::uint32_t wir;  // watermarks
  Frame txfifo, txhpb, rxfifo;
  std::uint32_t afr;  // which filters are on
  struct {
    std::uint32_t mask, id;
  } filter[4];
};
static_assert(sizeof(CanRegisters) == 0x84);
inline constexpr std::uintptr_t kCan0 = 0xFF060000;

struct UartRegisters {
  std::uint32_t control, mode;
  std::uint32_t int_enable, int_disable, int_mask, int_status;
  std::uint32_t baud_rate_gen;
  std::uint32_t receiver_timeout, receiver_trigger;
  std::uint32_t modem_control, modem_status;
  std::uint32_t channel_status;
  std::uint32_t fifo;
  std::uint32_t baud_rate_divider;
};
static_assert(sizeof(UartRegisters) == 0x38);
inline constexpr std::uintptr_t kUart1 = 0xFF010000;  // UART 0 is the console of Linux on the same chip

struct GqspiRegisters {  // the generic half of the quad SPI controller
  std::uint32_t cfg;
  std::uint32_t isr, ier, idr, imask;
  std::uint32_t en;
  std::uint32_t reserved0;
  std::uint32_t txd, rxd;
  std::uint32_t reserved1;
  std::uint32_t tx_thresh, rx_thresh;
  std::uint32_t gpio, reserved2, lpbk_dly_adj, reserved3;
  std::uint32_t gen_fifo;
  std::uint32_t sel;
  std::uint32_t reserved4, fifo_ctrl, gf_thresh;
};
static_assert(sizeof(GqspiRegisters) == 0x54);
inline constexpr std::uintptr_t kGqspi = 0xFF0F0100;

struct WatchdogRegisters {
  std::uint32_t mode, control, restart, status;
};
inline constexpr std::uintptr_t kSwdt0 = 0xFF150000;  // of the low-power domain

inline constexpr std::uintptr_t kResetReason = 0xFF5E0220;  // CRL_APB.RESET_REASON

}  // namespace thimble::board
