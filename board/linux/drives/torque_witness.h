// Compares the torque asked for with the one reported: derating, a dead phase, a blown fuse or a wrong torque constant shows there first.
//
// The torque asked for goes through the drive's lag, and a report may be of any of the last ticks: which one is not known, and where reports are
// rarer than ticks (an ODrive's current comes every 10 ms), a torque that alternates as often meets them always in the same phase. So a report
// is right that is between the least and the most of those ticks. A difference from that above 20 % + 0.02 of the peak for 20 ms is a limit that
// the drive did not name; for 200 ms it is a fault. Units: N m, s.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace thimble::board::drives {

class TorqueWitness {
 public:
  TorqueWitness(float peak_N_m, float lag_s, float period_s)
      : allowed_N_m_(kShareOfPeak * peak_N_m), period_s_(period_s), gain_(1 - std::exp(-period_s / lag_s)) {}

  void reset() noexcept {
    expected_N_m_ = {};
    difference_N_m_ = differs_s_ = 0;
    differed_ = false;
  }
  // Each tick.
  void asked(float torque_N_m) noexcept {
    const float lagged_N_m = expected_N_m_.back() + gain_ * (torque_N_m - expected_N_m_.back());
    std::rotate(expected_N_m_.begin(), expected_N_m_.begin() + 1, expected_N_m_.end());
    expected_N_m_.back() = lagged_N_m;
  }
  // With each torque reported; `ticks`: since the last one.
  void reported(float torque_N_m, unsigned ticks) noexcept {
    const auto [least_N_m, most_N_m] = std::ranges::minmax(expected_N_m_);
    const float nearest_N_m = std::clamp(torque_N_m, least_N_m, most_N_m);
    difference_N_m_ = torque_N_m - nearest_N_m;
    const bool differs = std::abs(difference_N_m_) > kShare * std::abs(nearest_N_m) + allowed_N_m_;
    // From the first report that differs on.
    differs_s_ = differs && differed_ ? differs_s_ + static_cast<float>(ticks) * period_s_ : 0;
    differed_ = differs;
  }
  // Of the last report, beyond what may have been expected.
  [[nodiscard]] float difference_N_m() const noexcept { return difference_N_m_; }
  [[nodiscard]] bool limited() const noexcept { return differs_s_ >= kShown_s; }
  [[nodiscard]] bool faulted() const noexcept { return differs_s_ >= kFault_s; }

 private:
  static constexpr float kShare = .2F;
  static constexpr float kShareOfPeak = .02F;
  static constexpr float kShown_s = .02F;
  static constexpr float kFault_s = .2F;

  static constexpr std::size_t kTicks =
      4;  // the command on its way, the drive's own loop, the reply on its way

  float allowed_N_m_;
  float period_s_;
  float gain_;
  std::array<float, kTicks> expected_N_m_{};  // the newest last
  float difference_N_m_ = 0;
  float differs_s_ = 0;
  bool differed_ = false;
};

}  // namespace thimble::board::drives
