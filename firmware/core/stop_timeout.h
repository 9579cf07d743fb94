// Time-out of a board's independent stop path: hardware that switches the drives off when the tick does not
// write its outputs. No fault of the software can make it longer, so a board that needs more refuses to arm.
#pragma once

#include <cstdint>
#include <optional>

namespace thimble::firmware {

inline constexpr std::uint32_t kShortestStop_us = 2000, kLongestStop_us = 5000;

// max(2 ms, (lost_ticks + 1) periods): it does not act on lost ticks that the parameter lost_ticks tolerates.
// Empty: more than 5 ms.
[[nodiscard]] constexpr std::optional<std::uint32_t> stop_timeout_us(std::uint32_t period_ns,
                                                                     std::uint32_t lost_ticks) noexcept {
  if (lost_ticks >= kLongestStop_us * 1000 / period_ns) return std::nullopt;
  const std::uint32_t wanted_us = (lost_ticks + 1) * period_ns / 1000;
  return wanted_us < kShortestStop_us ? kShortestStop_us : wanted_us;
}

// What Config::lacks says where it is empty, and the refusal of such a value of lost_ticks.
inline constexpr const char* kLacksShortStop = "lost_ticks_above_5_ms";

}  // namespace thimble::firmware
