// Time-out of a board's independent stop path: hardware that switches the drives off when the tick does not
// write its outputs. No fault of the software can make it longer, so a board that needs more refuses to arm.
#pragma once

#include <cstdint>
#include <optional>

namespace thimble::firmware {

inline constexpr std::uint32_t kShortestStop_us = 2000, kLongestStop_us = 5000;

// max(2 ms, (lost_ticks + 1) periods): it does not act on lost ticks that the parameter lost_ticks tolerates.
// Empty: more than 5 ms.
[[nodiscard]] constexpr std::optional<std::uint32_t> stop_timeout_us(float period_s,
                                                                     std::uint32_t lost_ticks) noexcept {
  const float periods_us = period_s * 1e6F * (static_cast<float>(lost_ticks) + 1.0F);
  if (!(periods_us < static_cast<float>(kLongestStop_us) + 0.5F)) return std::nullopt;
  const auto wanted_us = static_cast<std::uint32_t>(periods_us + 0.5F);
  return wanted_us < kShortestStop_us ? kShortestStop_us : wanted_us;
}

// What Config::lacks says where it is empty.
inline constexpr const char* kLacksShortStop = "lost_ticks_above_5_ms";

}  // namespace thimble::firmware
