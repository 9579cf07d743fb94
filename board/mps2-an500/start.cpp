// Reset handler, vector table and crash handler.
#include <cstdint>

#include "board/cortex/runtime.h"
#include "board/mps2-an500/registers.h"
#include "board/mps2-an500/restart.h"

extern "C" {
extern std::uint32_t stack_end;
[[noreturn]] void start();
[[noreturn]] void run_board();

[[noreturn]] void on_crash() { thimble::board::crash(); }
// An image that enables an interrupt defines the handler itself.
[[gnu::weak]] void on_sys_tick() { on_crash(); }
[[gnu::weak]] void on_watchdog() { on_crash(); }
[[gnu::weak]] void on_uart_receive() { on_crash(); }
[[gnu::weak]] void on_uart_transmit() { on_crash(); }

// Enables the floating-point unit (full access to coprocessors 10 and 11), before any code that may use it.
[[noreturn]] void start() {
  thimble::board::word(thimble::board::kCoprocessors) |= 0xFU << 20U;
  asm volatile("dsb\n isb" ::: "memory");
  thimble::board::start_runtime();
  run_board();
}
}

namespace {

using Handler = void (*)();
constexpr unsigned kSystemVectors = 16, kInterrupts = 32;

union Vector {
  const std::uint32_t* stack;
  Handler handler;
};

// Exceptions without a name here are crashes; no other interrupt is enabled.
[[gnu::section(".vectors"), gnu::used]] const Vector vectors[kSystemVectors + kInterrupts] = {
    {.stack = &stack_end},    {.handler = start},           {.handler = on_watchdog},  // NMI
    {.handler = on_crash},                                                             // hard fault
    {.handler = on_crash},                                                             // memory
    {.handler = on_crash},                                                             // bus
    {.handler = on_crash},                                                             // usage
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},                                // supervisor call
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},  // PendSV
    {.handler = on_sys_tick}, {.handler = on_uart_receive}, {.handler = on_uart_transmit},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
    {.handler = on_crash},    {.handler = on_crash},        {.handler = on_crash},
};

}  // namespace
