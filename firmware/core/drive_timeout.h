// How long the motor drives may stay on without a tick that writes them. A board gives it to the hardware that switches them off: a
// retriggerable circuit on the enable line, or a timer of its own. Shorter, and ticks that may be lost would switch them off.
#pragma once

#include <algorithm>
#include <cstdint>

namespace thimble::firmware {

inline constexpr float kShortestDriveTimeout_s = 2e-3F;
// A board whose period and lost_ticks ask for more is not started: 5 ms of the peak force are felt as a push of 0.04 N s.
inline constexpr float kLongestDriveTimeout_s = 5e-3F;

[[nodiscard]] constexpr float drive_timeout_s(float period_s, std::uint32_t lost_ticks) noexcept {
  return std::max(kShortestDriveTimeout_s, static_cast<float>(lost_ticks + 1) * period_s);
}

}  // namespace thimble::firmware
