// Start-up code up to run_board(), exception vectors and the exception handler. Names are those of the
// Cortex-R5 Technical Reference Manual.
#include <cstdint>

#include "board/cortex/runtime.h"
#include "board/zynqmp/memory.h"

extern "C" {
[[noreturn]] void start();
[[noreturn]] void run_board();

[[noreturn, gnu::used]] void run_from_start() {
  thimble::board::protect_memory();
  thimble::board::start_runtime();
  run_board();
}

// address: return address of the exception, up to 8 bytes behind its cause.
[[noreturn, gnu::used]] void on_exception(std::uint32_t address) { thimble::board::crash(address); }

// No interrupt is enabled, so every exception is a crash. The vectors are at 0, in the tightly coupled
// memory.
[[gnu::section(".vectors"), gnu::naked, gnu::used]] void vectors() {
  asm volatile(
      "b start\n"
      "b exception\n"  // undefined instruction
      "b exception\n"  // supervisor call
      "b exception\n"  // prefetch abort
      "b exception\n"  // data abort
      "b exception\n"
      "b exception\n"  // IRQ
      "b exception\n"  // FIQ
      "exception:\n"
      "  mov r0, lr\n"
      "  cpsid if, #0x1F\n"
      "  ldr sp, =stack_end\n"
      "  b on_exception\n"
      "  .ltorg\n");
}

// A restart also enters here, with caches and memory protection on.
[[gnu::naked, gnu::section(".text.start")]] void start() {
  asm volatile(
      "cpsid aif, #0x1F\n"           // system mode, interrupts off
      "mrc p15, 0, r0, c1, c0, 0\n"  // SCTLR
      "bic r0, r0, #(1 << 0)\n"      // M: memory protection off
      "bic r0, r0, #(1 << 2)\n"      // C: data cache off
      "bic r0, r0, #(1 << 12)\n"     // I: instruction cache off
      "bic r0, r0, #(1 << 13)\n"     // V: vectors at 0
      "bic r0, r0, #(1 << 30)\n"     // TE: exceptions in ARM state
      "dsb\n"
      "mcr p15, 0, r0, c1, c0, 0\n"
      "isb\n"
      "mov r0, #0\n"
      "mcr p15, 0, r0, c15, c5, 0\n"  // invalidate the data cache
      "mcr p15, 0, r0, c7, c5, 0\n"   // and the instruction cache
      "mcr p15, 0, r0, c7, c5, 6\n"   // and the branch predictor
      "dsb\n"
      "isb\n"
      "mrc p15, 0, r0, c1, c0, 2\n"  // CPACR: coprocessors 10 and 11, before anything uses floating point
      "orr r0, r0, #(0xF << 20)\n"
      "mcr p15, 0, r0, c1, c0, 2\n"
      "isb\n"
      "mov r0, #(1 << 30)\n"
      "vmsr fpexc, r0\n"
      "mov r0, #0\n"
      "vmsr fpscr, r0\n"  // subnormal numbers as on a PC
      "ldr sp, =stack_end\n"
      "b run_from_start\n"
      ".ltorg\n");
}
}
