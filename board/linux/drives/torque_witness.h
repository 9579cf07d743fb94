// Compares the torque asked for with the one reported: derating, a dead phase, a blown fuse or a wrong torque constant shows there first.
//
// The torque asked for goes through the drive's lag before it is compared. A difference above 20 % + 0.02 of the peak for 20 ms is a limit
// that the drive did not name; for 200 ms it is a fault. Units: N m, s.
#pragma once

#include <cmath>

namespace thimble::board::drives {

class TorqueWitness {
 public:
  TorqueWitness(float peak_N_m, float lag_s, float period_s)
      : allowed_N_m_(kShareOfPeak * peak_N_m), period_s_(period_s), gain_(1 - std::exp(-period_s / lag_s)) {}

  void reset() noexcept { *this = TorqueWitness(allowed_N_m_, period_s_, gain_, 0); }
  // Each tick.
  void asked(float torque_N_m) noexcept {
    before_N_m_ = expected_N_m_;
    expected_N_m_ += gain_ * (torque_N_m - expected_N_m_);
  }
  // With each torque reported; `ticks`: since the last one.
  void reported(float torque_N_m, unsigned ticks) noexcept {
    difference_N_m_ = torque_N_m - before_N_m_;
    const bool differs =
        std::abs(torque_N_m - expected_N_m_) > kShare * std::abs(expected_N_m_) + allowed_N_m_;
    // From the first report that differs on.
    differs_s_ = differs && differed_ ? differs_s_ + static_cast<float>(ticks) * period_s_ : 0;
    differed_ = differs;
  }
  // Of the last report, from what was asked for before its command: a reply shows the torque of then.
  [[nodiscard]] float difference_N_m() const noexcept { return difference_N_m_; }
  [[nodiscard]] bool limited() const noexcept { return differs_s_ >= kShown_s; }
  [[nodiscard]] bool faulted() const noexcept { return differs_s_ >= kFault_s; }

 private:
  static constexpr float kShare = .2F;
  static constexpr float kShareOfPeak = .02F;
  static constexpr float kShown_s = .02F;
  static constexpr float kFault_s = .2F;

  TorqueWitness(float allowed_N_m, float period_s, float gain, float expected_N_m)
      : allowed_N_m_(allowed_N_m), period_s_(period_s), gain_(gain), expected_N_m_(expected_N_m) {}

  float allowed_N_m_;
  float period_s_;
  float gain_;
  float expected_N_m_ = 0;
  float before_N_m_ = 0;
  float difference_N_m_ = 0;
  float differs_s_ = 0;
  bool differed_ = false;
};

}  // namespace thimble::board::drives
