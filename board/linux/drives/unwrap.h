// A position without wraps from one that wraps within a range (MIT mode: +-12.5 rad).
//
// The nearest continuation of the last position is taken, so no step seen is above half the range. A longer step than the joint's top
// speed allows is a jump: ticks were lost, the drive rebooted, or it lost its turn count.
#pragma once

#include <cmath>

namespace thimble::board::drives {

class Unwrap {
 public:
  // range_rad: the distance of a wrap; 0: the position does not wrap. most_rad: the longest step that is no jump.
  constexpr Unwrap(float range_rad, float most_rad) : range_rad_(range_rad), most_rad_(most_rad) {}

  // False: a jump; the position follows it all the same, so that one jump is one fault.
  [[nodiscard]] bool take(float wrapped_rad) noexcept {
    if (!started_) {
      started_ = true;
      last_ = position_ = static_cast<double>(wrapped_rad);
      return true;
    }
    double step = static_cast<double>(wrapped_rad) - last_;
    const double range = static_cast<double>(range_rad_);
    if (range > 0) step -= range * std::round(step / range);
    last_ = static_cast<double>(wrapped_rad);
    position_ += step;
    return std::abs(step) <= static_cast<double>(most_rad_);
  }
  // Since reset(), the first position as it was.
  [[nodiscard]] double position_rad() const noexcept { return position_; }
  void reset() noexcept { started_ = false; }

 private:
  float range_rad_;
  float most_rad_;
  bool started_ = false;
  double last_ = 0;
  double position_ = 0;
};

}  // namespace thimble::board::drives
