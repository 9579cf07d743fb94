// What makes a thread of Linux keep its time: memory that stays, a stack that is there, a priority above all else, a processor of
// its own. Each function says what it could not do and goes on.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "board/linux/missing.h"

namespace thimble::board {

// All memory that the process has now is there and stays; what it gets later stays from the first touch on. (So that 128 MB
// of scene slots take only what a scene takes.)
[[nodiscard]] std::optional<Missing> lock_memory();

// The calling thread: SCHED_FIFO, and the processor where one is given.
[[nodiscard]] std::vector<Missing> become_realtime(int priority, std::optional<int> cpu);
// What that would lack, without keeping it.
[[nodiscard]] std::vector<Missing> try_realtime(int priority, std::optional<int> cpu);

// Touches the calling thread's stack as deep as a tick may go.
void prefault_stack() noexcept;
inline constexpr std::size_t kServoStackBytes = std::size_t{1} << 20U;  // for pthread_attr_setstacksize

// Page faults of the calling thread since it began.
[[nodiscard]] long page_faults() noexcept;

}  // namespace thimble::board
