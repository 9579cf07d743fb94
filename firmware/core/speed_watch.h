// Tells when the tip moves as no hand moves it: a motor that is reversed or stuck, or a force at the wrong place, accelerates it. One an
// arm; asked once a tick while armed.
//
// The limit holds while the arm gives a force. A hand may come faster, up to twice the limit, and meet a wall: then the limit begins at
// its speed and falls by kBraked_m_s2, which is less than a wall slows a hand. A force that changes at once changes the stretch of the
// cables, and the motors follow: 1.4 m/s for 2 ms when a layer of tissue gave way at 6 N, 1.1 m/s when a force of 4 N turned by 90 degrees
// while the tip itself moved at 0.1 m/s (endurance_test). So the limit is twice as high just after. Units: SI. Cannot fail.
#pragma once

#include <algorithm>

#include "kinematics/vector.h"

namespace thimble::firmware {

class SpeedWatch {
 public:
  static constexpr float kForce_N = 0.3F;  // less counts as none
  static constexpr float kBraked_m_s2 = 10.0F;
  static constexpr float kNoise = 1.1F;  // of the measured speed
  static constexpr float kChange_N = 2.0F,
                         kRecoil_s = 0.01F;  // within a tick, in any direction; how long the motors recoil

  void reset() noexcept { *this = {}; }

  [[nodiscard]] bool too_fast(float speed_m_s, const Vec3& force_N, float limit_m_s,
                              float period_s) noexcept {
    recoil_s_ = (force_N - last_N_).norm() > kChange_N ? kRecoil_s : std::max(recoil_s_ - period_s, 0.0F);
    last_N_ = force_N;
    if (force_N.norm() < kForce_N || recoil_s_ > 0.0F) {
      allowed_m_s_ = speed_m_s;
      return speed_m_s > 2 * limit_m_s;
    }
    allowed_m_s_ = std::max(allowed_m_s_ - kBraked_m_s2 * period_s, limit_m_s);
    return speed_m_s > kNoise * allowed_m_s_;
  }

 private:
  float allowed_m_s_ = 0;
  Vec3 last_N_ = Vec3::Zero();
  float recoil_s_ = 0;
};

}  // namespace thimble::firmware
