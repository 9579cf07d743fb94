// Speed of one encoder by first-order adaptive windowing (Janabi-Sharifi, Hayward, Chen 2000): the longest
// recent window in which the least-squares line stays within one count of every reading, and that line's
// slope. Slow motion gets a long window and little noise, fast motion a short one and little lag. The
// firmware calls update() once per joint and tick; tip velocity is the Jacobian times the joints' speeds.
//
// The window never exceeds kMaxWindow_s, so the lag never exceeds half of it; tests/unit/kinematics measures
// lag and noise. No heap; at most kMaxWindow^2 short steps a call, kMaxWindow in the common case.
#pragma once

#include <array>
#include <cstdint>

namespace thimble::kinematics {

class VelocityEstimator {
 public:
  static constexpr int kMaxWindow = 32;  // readings, whatever the rate
  static constexpr float kMaxWindow_s = 2.0e-3F;

  explicit VelocityEstimator(float period_s = 1.0e-3F) noexcept;

  // Forgets the past: the encoder stands still at `counts`.
  void reset(std::int32_t counts) noexcept;

  // Takes this tick's reading, gives counts per second.
  [[nodiscard]] float update(std::int32_t counts) noexcept;

 private:
  std::array<std::int32_t, kMaxWindow + 1> history_{};  // ring; newest at head_
  int head_ = 0;
  int window_;
  float rate_Hz_;
};

}  // namespace thimble::kinematics
