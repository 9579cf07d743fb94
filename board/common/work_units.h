// What rendering may do in a tick (Config::work_units) on a Cortex-M7 at 480 MHz or a Cortex-R5F at 500 MHz: a quarter of the period at
// 100 cycles a unit. The rest is for what a unit of bodies costs more than that (up to 290 instructions in the tests cortex.bound), for
// the rest of the tick, and for the background (docs/time.md). No less than each arm needs: above 12 kHz that is a larger part of the period.
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/core/config.h"

namespace thimble::board {

inline constexpr float kUnits_s = 1.2e6F;

[[nodiscard]] constexpr std::uint32_t work_units(float period_s, std::uint32_t arms) noexcept {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): small and above 0
  return std::max(static_cast<std::uint32_t>(kUnits_s * period_s + 0.5F), firmware::kLeastWork * arms);
}

}  // namespace thimble::board
