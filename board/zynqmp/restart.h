// Restarts, and why the last one was: words in memory that a restart leaves as they are, and the reset-status register.
//
// A restart of this board is the processor's own, from its first instruction on: the chip goes on, and Linux on its other cores with
// it.
#pragma once

#include <cstdint>

namespace thimble::board {

enum class Restart : std::uint32_t { kHost = 1, kCrash = 2 };

struct StartReason {
  const char* name =
      "";  // "power_on", "host", "crash", "watchdog", "reset_button", "software", "debugger"; empty: not known
  std::uint32_t address = 0;  // of a crash: where the processor was; 0: not known
};
// Why this start. Once: the words are forgotten.
[[nodiscard]] StartReason take_start_reason() noexcept;

[[noreturn]] void restart(Restart reason, std::uint32_t address = 0) noexcept;

}  // namespace thimble::board
