// Speed of one encoder by first-order adaptive windowing (Janabi-Sharifi, Hayward, Chen 2000): the slope of
// the least-squares line over the longest recent window in which the line is within one count of every
// reading. Slow motion gives a long window with low noise, fast motion a short one with low lag. The firmware
// calls update() once per joint and tick; the tip velocity is the Jacobian times the joint speeds.
//
// The window is at most kMaxWindow_s, so the lag is at most half of it; tests/unit/kinematics measures lag
// and noise. No heap; at most kMaxWindow^2 short steps per call, kMaxWindow in the common case. Exact while the counts change by less than
// four million in a window.
#pragma once

#include <array>
#include <cstdint>

namespace thimble::kinematics {

class VelocityEstimator {
 public:
  static constexpr int kMaxWindow = 32;  // readings, at any tick rate
  static constexpr float kMaxWindow_s = 2.0e-3F;

  explicit VelocityEstimator(float period_s = 1.0e-3F) noexcept;

  // Discards the history; the encoder is assumed to have been at rest at `counts`.
  void reset(std::int32_t counts) noexcept;

  // Adds a reading; returns counts per second. periods: since the reading before, at least 1. Readings that are missing are put on the
  // line between the two.
  [[nodiscard]] float update(std::int32_t counts, std::uint32_t periods = 1) noexcept;

 private:
  void add(std::int32_t counts) noexcept;
  [[nodiscard]] std::int32_t before(int ticks) const noexcept;  // the reading; 0: the newest

  std::array<std::int32_t, kMaxWindow + 1> history_{};  // ring; newest at head_
  int head_ = 0;
  int window_;
  // Of the window's readings, and of each times its age in ticks: modulo 2^32.
  std::uint32_t sum_ = 0, moment_ = 0;
  float rate_Hz_;
};

}  // namespace thimble::kinematics
