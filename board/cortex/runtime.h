// What a C++ program finds on a bare board before main: its data in place and its constructors run. For a board's start-up
// code, once its stack and floating-point unit work.
#pragma once

#include <cstdint>

namespace thimble::board {

// Copies .data, clears .bss, runs the constructors. The linker script (board/cortex/sections.ld) names the ends.
void start_runtime() noexcept;

// A board defines it: motors off, then whatever it does after a crash. What the runtime calls where a program on a PC would
// abort: a pure virtual call, std::terminate, a failed FlatBuffers assertion's trap handler.
// address: near what failed; 0: not known.
[[noreturn]] void crash(std::uint32_t address = 0) noexcept;

}  // namespace thimble::board
