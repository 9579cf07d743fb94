#include "board/mps2-an500/restart.h"

#include <array>
#include <cstdint>

#include "board/mps2-an500/registers.h"

namespace thimble::board {
namespace {

// Stored twice, the second time inverted, so random memory content at power-on is not taken for a reason.
[[gnu::section(".kept")]] std::array<std::uint32_t, 2> kept;

}  // namespace

const char* take_restart_reason() noexcept {
  const std::uint32_t reason = kept[1] == ~kept[0] ? kept[0] : 0;
  kept = {};
  switch (static_cast<Restart>(reason)) {
    case Restart::kHost:
      return "host";
    case Restart::kWatchdog:
      return "watchdog";
    case Restart::kCrash:
      return "crash";
  }
  return "power_on";
}

void remember(Restart reason) noexcept {
  kept[0] = static_cast<std::uint32_t>(reason);
  kept[1] = ~kept[0];
}

void restart(Restart reason) noexcept {
  remember(reason);
  asm volatile("dsb" ::: "memory");
  word(kResetControl) = kResetRequest;
  for (;;) {
  }
}

}  // namespace thimble::board
