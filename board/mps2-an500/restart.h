// Restarts, and why the last one was: a word in memory that a reset leaves as it is.
#pragma once

namespace thimble::board {

enum class Restart : unsigned { kHost = 1, kWatchdog = 2, kCrash = 3 };

// Why this start: "power_on", "host", "watchdog", "crash". Once: the word is forgotten.
[[nodiscard]] const char* take_restart_reason() noexcept;

void remember(Restart reason) noexcept;  // for the next start
[[noreturn]] void restart(Restart reason) noexcept;

}  // namespace thimble::board
