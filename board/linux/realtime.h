// Real-time settings of a Linux thread: locked memory, a touched stack, a high priority, a processor of its
// own. Each function reports what it could not set, and continues.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "board/linux/missing.h"

namespace thimble::board {

// Locks all present memory of the process, and later memory on first use (so 128 MB of scene slots occupy
// only the size of the scenes).
[[nodiscard]] std::optional<Missing> lock_memory();

// Sets SCHED_FIFO, and the processor if one is given, for the calling thread.
[[nodiscard]] std::vector<Missing> become_realtime(int priority, std::optional<int> cpu);
// Tries the same in a temporary thread and reports what is missing.
[[nodiscard]] std::vector<Missing> try_realtime(int priority, std::optional<int> cpu);

// Touches the stack of the calling thread to the depth that a tick may use.
void prefault_stack() noexcept;
inline constexpr std::size_t kServoStackBytes = std::size_t{1} << 20U;  // for pthread_attr_setstacksize

// Page faults of the calling thread since its start.
[[nodiscard]] long page_faults() noexcept;

}  // namespace thimble::board
