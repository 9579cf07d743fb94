// One joint's incremental encoder: a raw counter of 16 or 32 bits in, a joint angle out. The firmware calls
// update() for every joint in every tick, and home() when the joint's angle is known.
//
// A counter that moved more than the joint can since the last reading is implausible: the reading is refused,
// the angle stays, and the caller trips. Wraps are followed as long as a tick moves less than half the
// counter's range.
#pragma once

#include <cstdint>

#include "kinematics/arm_model.h"

namespace thimble::kinematics {

enum class EncoderStatus : std::uint8_t { kOk, kJump };

class JointEncoder {
 public:
  JointEncoder() noexcept = default;

  // period_s: between two readings; with the joint's top speed it bounds the counts per tick (at least 2: one
  // count of jitter either way is no fault).
  JointEncoder(const ArmModel& model, int joint, float period_s) noexcept
      : rad_per_count_(model.rad_per_count(joint)), width_(model.counter_width) {
    const float counts =
        model.max_joint_speed_rad_s * period_s / (rad_per_count_ < 0 ? -rad_per_count_ : rad_per_count_);
    max_counts_per_tick_ = counts < 2.0F ? 2 : static_cast<std::int32_t>(counts) + 1;
  }

  // The joint stands at angle_rad while the counter shows raw. Forgets everything before.
  void home(std::uint32_t raw, float angle_rad) noexcept {
    last_raw_ = raw;
    counts_ = 0;
    offset_rad_ = angle_rad;
  }

  // The counter shows raw, and has moved by counts since the joint stood at home_rad.
  void resume(std::uint32_t raw, std::int32_t counts, float home_rad) noexcept {
    last_raw_ = raw;
    counts_ = counts;
    offset_rad_ = home_rad;
  }

  [[nodiscard]] EncoderStatus update(std::uint32_t raw) noexcept {
    const std::uint32_t difference = raw - last_raw_;
    const std::int32_t delta = width_ == CounterWidth::k16
                                   ? static_cast<std::int16_t>(static_cast<std::uint16_t>(difference))
                                   : static_cast<std::int32_t>(difference);
    if (delta > max_counts_per_tick_ || delta < -max_counts_per_tick_) return EncoderStatus::kJump;
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
  float rad_per_count_ = 0.0F;
  float offset_rad_ = 0.0F;
  std::uint32_t last_raw_ = 0;
  std::int32_t counts_ = 0;
  std::int32_t max_counts_per_tick_ = 2;
  CounterWidth width_ = CounterWidth::k32;
};

}  // namespace thimble::kinematics
