// Restarts, and the reason of the last one, in a word of memory that survives a reset.
#pragma once

namespace thimble::board {

enum class Restart : unsigned { kHost = 1, kWatchdog = 2, kCrash = 3 };

// Reason of this start: "power_on", "host", "watchdog", "crash". Call it once: it clears the word.
[[nodiscard]] const char* take_restart_reason() noexcept;

void remember(Restart reason) noexcept;  // stores the reason for the next start
[[noreturn]] void restart(Restart reason) noexcept;

}  // namespace thimble::board
