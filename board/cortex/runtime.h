// C++ runtime initialisation on a bare-metal board: initial data and constructors. Called by a board's
// start-up code after the stack and the floating-point unit are set up.
#pragma once

#include <cstdint>

namespace thimble::board {

// Copies .data, clears .bss, runs the constructors. The linker script (board/cortex/sections.ld) defines the
// section ends.
void start_runtime() noexcept;

// Defined by the board: switches the motors off, then handles the crash. The runtime calls it where a program
// on a PC would abort: a pure virtual call, std::terminate, the trap of a failed FlatBuffers assertion.
// address: near the failure; 0: unknown.
[[noreturn]] void crash(std::uint32_t address = 0) noexcept;

}  // namespace thimble::board
