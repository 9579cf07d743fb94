// Suspects a frozen encoder: a joint whose torque changes by much should move a count soon after, however firm the hand. Called every
// tick while armed, once a joint.
//
// Evidence: 25 % of the Premium's peak joint torque is 2 N at the tip; a hand of 2000 N/m gives way 1 mm to
// that, 40 counts. It proves nothing where a hand holds the arm: the hand's force may change with the arm's while the tip slides in a
// direction that other joints move (endurance_test found it on ice), so such a joint is probed (encoder_probe.h). An arm that moves by
// itself has no hand at it: there it is a fault.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "firmware/core/encoder_place.h"

namespace thimble::firmware {

class EncoderWatch {
 public:
  void reset() noexcept { time_s_ = -1.0F; }
  // When another motion begins: the torques of the last one say nothing of it. A joint that is held between two counts would be frozen with the
  // first torque of the next motion.
  void forget_torques() noexcept {
    time_s_ = std::min(time_s_, 0.0F);
    lowest_N_m_ = std::numeric_limits<float>::infinity();
    highest_N_m_ = -lowest_N_m_;
  }

  // torque: what the joint was last driven with. True: while the count stood still the torque changed by more
  // than max_change, and min_time_s later it still stands.
  [[nodiscard]] bool frozen(std::int32_t counts, float torque_N_m, float max_change_N_m, float min_time_s,
                            float period_s) noexcept {
    if (time_s_ < 0.0F || place_.left(counts) != 0) {
      if (time_s_ < 0.0F) place_.reset(counts);
      time_s_ = 0.0F;
      lowest_N_m_ = highest_N_m_ = torque_N_m;
      return false;
    }
    lowest_N_m_ = std::min(lowest_N_m_, torque_N_m);
    highest_N_m_ = std::max(highest_N_m_, torque_N_m);
    if (highest_N_m_ - lowest_N_m_ > max_change_N_m) time_s_ += period_s;
    return time_s_ >= min_time_s;
  }

 private:
  EncoderPlace place_;
  float time_s_ = -1.0F;  // since the torque changed by much, even if it came back; negative: not started
  float lowest_N_m_ = 0;
  float highest_N_m_ = 0;
};

}  // namespace thimble::firmware
