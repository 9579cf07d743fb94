#include "board/zynqmp/restart.h"

#include "board/zynqmp/registers.h"

extern "C" [[noreturn]] void start();

namespace thimble::board {
namespace {

// The first word is stored twice, the second time inverted, so random memory content is not taken for a
// reason. One cache line.
struct alignas(32) Kept {
  std::uint32_t reason;
  std::uint32_t inverted;
  std::uint32_t address;
};
[[gnu::section(".kept")]] Kept kept;

struct ResetBit {
  std::uint32_t bit;
  const char* name;
};
// Bits of RESET_REASON; the first one that is set applies. The PMU resets the system when the watchdog
// expires.
constexpr ResetBit kResetBits[] = {{1U << 0U, "power_on"}, {1U << 1U, "power_on"},     {1U << 2U, "watchdog"},
                                   {1U << 3U, "software"}, {1U << 4U, "reset_button"}, {1U << 5U, "software"},
                                   {1U << 6U, "debugger"}};

}  // namespace

StartReason take_start_reason() noexcept {
  const Kept was = kept;
  kept = {};
  if (was.inverted == ~was.reason) {
    switch (static_cast<Restart>(was.reason)) {
      case Restart::kHost:
        return {"host", 0};
      case Restart::kCrash:
        return {"crash", was.address};
    }
  }
  const std::uint32_t bits = word(kResetReason);
  word(kResetReason) = bits;  // write 1 to clear
  for (const ResetBit& row : kResetBits) {
    if ((bits & row.bit) != 0) return {row.name, 0};
  }
  return {};
}

void restart(Restart reason, std::uint32_t address) noexcept {
  kept = {static_cast<std::uint32_t>(reason), ~static_cast<std::uint32_t>(reason), address};
  // The start-up code invalidates the data cache, so the words must be written to memory before (DCCMVAC).
  asm volatile("mcr p15, 0, %0, c7, c10, 1\n dsb" ::"r"(&kept) : "memory");
  start();
}

}  // namespace thimble::board
