// The motors of one arm by an order for its axes, for the commissioning of an arm: a torque of one axis, and a spring and a damper of every axis on
// the way between two places. It ends by itself: after its time, or where an axis goes further or faster than the order allows, or takes more
// energy. AxisSource (axis_source.h) calls tick() once a tick while the arm is armed and the drive is active(). A host that has the counts of every
// tick computes the same torques with this class.
//
//   torque of axis j   [ j == axis:  offset + slope t + amplitude cos(2 pi f t) ]
//                      + K (from + s(t) (to - from) - angle) + B (s'(t) (to - from) - speed),   at most most_torque
//   from               the place that the last order holds, else where the axis is
//   s(t)               0 to 1 in move_s: the speed rises over the first quarter, is constant, and falls over the last one
//   afterwards         hold: the place `to` until the next order. Else no torque for coast_s, then the arm is let go
//
// Units: rad or m, N m or N, s. The loops are over the axes. Cannot fail: a value that is not finite gives a torque that is not, which is a fault.
#pragma once

#include <cstdint>

#include "firmware/link/messages.h"
#include "kinematics/arm_data.h"

namespace thimble::firmware {

using Axes = kinematics::PerAxis<float>;

class AxisDrive {
 public:
  static constexpr float kFilter_s = 0.002F;     // of the speed that is damped
  static constexpr float kSpeedTime_s = 0.005F;  // over which the speed is taken that ends a motion
  static constexpr float kRamp = 0.25F;          // part of move_s

  using Phase = link::AxisPhase;
  using End = link::AxisEnd;

  void start(const link::AxisOrder& order, const Axes& angle) noexcept;
  // angle: of the axes in this tick. The torques of the axes, which the caller may limit.
  Axes& tick(const Axes& angle, int axes, float period_s) noexcept;
  void stop() noexcept;  // it ends

  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] End end() const noexcept { return end_; }
  [[nodiscard]] bool active() const noexcept { return phase_ != Phase::kNone; }
  [[nodiscard]] bool under_way() const noexcept {
    return phase_ == Phase::kDriving || phase_ == Phase::kCoasting;
  }
  [[nodiscard]] std::uint32_t driven_ticks() const noexcept { return driven_ticks_; }
  [[nodiscard]] std::uint8_t arm() const noexcept { return order_.arm; }
  // It follows a place, and so would run away without the axes' encoders.
  [[nodiscard]] bool follows() const noexcept { return follows_; }
  [[nodiscard]] const Axes& torque_N_m() const noexcept { return torque_N_m_; }

 private:
  void sense(const Axes& angle, int axes, float period_s) noexcept;
  [[nodiscard]] End limit(const Axes& angle, int axes, float period_s) noexcept;
  void command(const Axes& angle, int axes, float period_s) noexcept;

  link::AxisOrder order_;
  Phase phase_ = Phase::kNone;
  End end_ = End::kNotYet;
  bool follows_ = false;
  std::uint32_t driven_ticks_ = 0;
  std::uint32_t ticks_ =
      0;            // since it began, or coasts: a sum of a minute's periods would be off by many of them
  float part_ = 0;  // of its way, so far
  float turn_ = 0;  // of the tone, rad
  float block_s_ = 0, energy_J_ = 0;
  Axes from_ = Axes::Zero(), begin_ = Axes::Zero(), block_ = Axes::Zero(), last_ = Axes::Zero();
  Axes speed_ = Axes::Zero();
  Axes torque_N_m_ = Axes::Zero();
};

}  // namespace thimble::firmware
