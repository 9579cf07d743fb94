// Tells when the tip moves as no hand moves it: a motor that is reversed or stuck, or a force at the wrong place, accelerates it. One an
// arm; asked once a tick while armed.
//
// The limit holds while the arm gives a force. A hand may come faster, up to twice the limit, and meet a wall: then the limit begins at
// its speed and falls by kBraked_m_s2, which is less than a wall slows a hand. Units: SI. Cannot fail.
#pragma once

#include <algorithm>

namespace thimble::firmware {

class SpeedWatch {
 public:
  static constexpr float kForce_N = 0.3F;  // less counts as none
  static constexpr float kBraked_m_s2 = 10.0F;
  static constexpr float kNoise = 1.1F;  // of the measured speed

  void reset() noexcept { allowed_m_s_ = 0; }

  [[nodiscard]] bool too_fast(float speed_m_s, float force_N, float limit_m_s, float period_s) noexcept {
    if (force_N < kForce_N) {
      allowed_m_s_ = speed_m_s;
      return speed_m_s > 2 * limit_m_s;
    }
    allowed_m_s_ = std::max(allowed_m_s_ - kBraked_m_s2 * period_s, limit_m_s);
    return speed_m_s > kNoise * allowed_m_s_;
  }

 private:
  float allowed_m_s_ = 0;
};

}  // namespace thimble::firmware
