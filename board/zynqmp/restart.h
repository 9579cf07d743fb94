// Restarts, and the reason of the last one: from words in memory that survive a restart, and from the
// reset-status register.
//
// A restart affects this processor only, from its first instruction on. The chip, and Linux on its other
// cores, continue.
#pragma once

#include <cstdint>

namespace thimble::board {

enum class Restart : std::uint32_t { kHost = 1, kCrash = 2 };

struct StartReason {
  const char* name =
      "";  // "power_on", "host", "crash", "watchdog", "reset_button", "software", "debugger"; empty: not known
  std::uint32_t address = 0;  // address of a crash; 0: unknown
};
// Reason of this start. Call it once: it clears the words.
[[nodiscard]] StartReason take_start_reason() noexcept;

[[noreturn]] void restart(Restart reason, std::uint32_t address = 0) noexcept;

}  // namespace thimble::board
