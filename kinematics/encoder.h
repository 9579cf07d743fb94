// The incremental encoder of one joint: converts a raw counter of 8 to 32 bits to a joint angle. The
// firmware calls update() for every joint in every tick, and home() when the joint angle is known.
//
// A counter change above what the joint can move since the last reading is implausible: the reading is
// rejected, the angle is unchanged, and the caller raises a fault. Counter wraps are handled if the change
// per tick is below half of the counter's range.
#pragma once

#include <algorithm>
#include <cstdint>

#include "kinematics/arm_data.h"

namespace thimble::kinematics {

enum class EncoderStatus : std::uint8_t { kOk, kJump };

class JointEncoder {
 public:
  JointEncoder() noexcept = default;

  // period_s: time between two readings. Together with the maximum joint speed it gives the maximum counts
  // per tick (at least 2, so that one count of jitter in either direction is not a fault).
  JointEncoder(const AxisData& axis, float max_speed_rad_s, float period_s) noexcept
      : rad_per_count_(axis.rad_per_count()), unused_bits_(32U - axis.counter_bits) {
    const float counts = max_speed_rad_s * period_s / (rad_per_count_ < 0 ? -rad_per_count_ : rad_per_count_);
    constexpr float kMost = 3.3e7F;  // kMaxPeriods times as many are an std::int32_t
    max_counts_per_tick_ = counts < 2.0F ? 2 : static_cast<std::int32_t>(std::min(counts, kMost)) + 1;
  }

  // Sets the reference: the joint is at angle_rad while the counter reads raw. Discards the previous state.
  void home(std::uint32_t raw, float angle_rad) noexcept {
    last_raw_ = raw;
    counts_ = 0;
    offset_rad_ = angle_rad;
  }

  // Restores a recorded state: the counter reads raw and has changed by counts since the joint was at
  // home_rad.
  void resume(std::uint32_t raw, std::int32_t counts, float home_rad) noexcept {
    last_raw_ = raw;
    counts_ = counts;
    offset_rad_ = home_rad;
  }

  // periods: since the reading before, at least 1.
  [[nodiscard]] EncoderStatus update(std::uint32_t raw, std::uint32_t periods = 1) noexcept {
    // Of as many bits as the counter has, with its sign.
    const std::int32_t delta = static_cast<std::int32_t>((raw - last_raw_) << unused_bits_) >> unused_bits_;
    const std::int32_t most =
        max_counts_per_tick_ * static_cast<std::int32_t>(std::min(periods, kMaxPeriods));
    if (delta > most || delta < -most) return EncoderStatus::kJump;
    last_raw_ = raw;
    counts_ =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(counts_) + static_cast<std::uint32_t>(delta));
    return EncoderStatus::kOk;
  }

  [[nodiscard]] std::int32_t counts() const noexcept { return counts_; }  // since home(), unwrapped
  [[nodiscard]] float angle_rad() const noexcept {
    return offset_rad_ + static_cast<float>(counts_) * rad_per_count_;
  }
  [[nodiscard]] std::uint32_t raw() const noexcept { return last_raw_; }  // of the last reading
  [[nodiscard]] float rad_per_count() const noexcept { return rad_per_count_; }
  [[nodiscard]] std::int32_t max_counts_per_tick() const noexcept { return max_counts_per_tick_; }

 private:
  static constexpr std::uint32_t kMaxPeriods = 64;  // more are lost only where a fault has come before

  float rad_per_count_ = 0.0F;
  float offset_rad_ = 0.0F;
  std::uint32_t last_raw_ = 0;
  std::int32_t counts_ = 0;
  std::int32_t max_counts_per_tick_ = 2;
  std::uint32_t unused_bits_ = 0;
};

}  // namespace thimble::kinematics
