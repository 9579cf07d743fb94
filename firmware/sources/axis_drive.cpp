#include "firmware/sources/axis_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinematics/trig.h"

namespace thimble::firmware {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr std::uint32_t kMostTicks = 1U << 24U;  // a float has each of them; longer than any way

// Time after so many ticks, and whether that is the tick nearest to a time, or later.
float after_s(std::uint32_t ticks, float period_s) noexcept { return static_cast<float>(ticks) * period_s; }
bool is_over(float time_s, std::uint32_t ticks, float period_s) noexcept {
  return after_s(ticks, period_s) + 0.5F * period_s > time_s;
}

// s and s' of the header, at a part of move_s.
struct Way {
  float part, speed;
};
Way way_at(float at) noexcept {
  constexpr float kRamp = AxisDrive::kRamp, kTop = 1 / (1 - kRamp);
  if (at >= 1) return {1, 0};
  if (at < kRamp) return {0.5F * kTop / kRamp * at * at, kTop / kRamp * at};
  const float rest = 1 - at;
  if (rest < kRamp) return {1 - 0.5F * kTop / kRamp * rest * rest, kTop / kRamp * rest};
  return {kTop * (at - 0.5F * kRamp), kTop};
}

std::size_t at(int axis) noexcept { return static_cast<std::size_t>(axis); }

}  // namespace

void AxisDrive::start(const link::AxisOrder& order, const Axes& angle) noexcept {
  const Axes held = from_;
  from_ = angle;
  if (phase_ == Phase::kHolding)
    for (int j = 0; j < from_.size(); ++j) from_[j] = held[j] + part_ * (order_.to_rad[at(j)] - held[j]);
  if (!active()) {
    last_ = angle;
    speed_.setZero();
  }
  torque_N_m_.setZero();  // its energy is not that of the last order
  order_ = order;
  phase_ = Phase::kDriving;
  end_ = End::kNotYet;
  follows_ = false;
  for (const float stiffness : order.stiffness_N_m_rad) follows_ = follows_ || stiffness > 0;
  driven_ticks_ = ticks_ = 0;
  turn_ = block_s_ = energy_J_ = 0;
  begin_ = block_ = angle;
}

void AxisDrive::stop() noexcept {
  if (phase_ == Phase::kDriving) end_ = End::kStopped;
  phase_ = Phase::kNone;
  torque_N_m_.setZero();
}

void AxisDrive::sense(const Axes& angle, int axes, float period_s) noexcept {
  energy_J_ += torque_N_m_[order_.axis] * (angle[order_.axis] - last_[order_.axis]);
  const float part = period_s / (kFilter_s + period_s);
  for (int j = 0; j < axes; ++j) speed_[j] += part * ((angle[j] - last_[j]) / period_s - speed_[j]);
  last_ = angle;
}

// What ends it in this tick, or kNotYet.
AxisDrive::End AxisDrive::limit(const Axes& angle, int axes, float period_s) noexcept {
  if (order_.most_energy_J > 0 && energy_J_ > order_.most_energy_J) return End::kEnergy;
  block_s_ += period_s;
  const bool whole = block_s_ >= kSpeedTime_s;
  for (int j = 0; j < axes; ++j) {
    const float most = order_.most_way_rad[at(j)], fastest = order_.most_speed_rad_s[at(j)];
    if (most > 0 && std::abs(angle[j] - begin_[j]) > most) return End::kWay;
    if (whole && fastest > 0 && std::abs(angle[j] - block_[j]) > fastest * block_s_) return End::kSpeed;
  }
  if (whole) {
    block_ = angle;
    block_s_ = 0;
  }
  return End::kNotYet;
}

void AxisDrive::command(const Axes& angle, int axes, float period_s) noexcept {
  const float time_s = after_s(ticks_, period_s);
  const Way along = way_at(order_.move_s > 0 ? time_s / order_.move_s : 1.0F);
  const float per_s = order_.move_s > 0 ? 1 / order_.move_s : 0.0F;
  for (int j = 0; j < axes; ++j) {
    const float from = from_[j], way = order_.to_rad[at(j)] - from;
    float torque_N_m = order_.stiffness_N_m_rad[at(j)] * (from + along.part * way - angle[j]) +
                       order_.damping_N_m_s_rad[at(j)] * (along.speed * per_s * way - speed_[j]);
    if (j == order_.axis && phase_ == Phase::kDriving)
      torque_N_m += order_.offset_N_m + order_.slope_N_m_s * time_s +
                    order_.amplitude_N_m * kinematics::sin_cos(turn_).cos;
    const float most = order_.most_torque_N_m[at(j)];
    torque_N_m_[j] = std::isfinite(torque_N_m) ? std::clamp(torque_N_m, -most, most) : torque_N_m;
  }
  part_ = along.part;
  if (ticks_ < kMostTicks) ++ticks_;
  turn_ += kTurn * order_.frequency_Hz * period_s;
  if (turn_ > kTurn) turn_ -= kTurn * static_cast<float>(static_cast<int>(turn_ / kTurn));
}

Axes& AxisDrive::tick(const Axes& angle, int axes, float period_s) noexcept {
  sense(angle, axes, period_s);
  if (phase_ == Phase::kDriving || phase_ == Phase::kHolding) {
    const End reason = ticks_ == 0 ? End::kNotYet : limit(angle, axes, period_s);
    if (reason != End::kNotYet || (phase_ == Phase::kDriving && is_over(order_.driven_s, ticks_, period_s))) {
      end_ = reason != End::kNotYet ? reason : End::kTime;
      phase_ = end_ == End::kTime && order_.hold ? Phase::kHolding : Phase::kCoasting;
      if (phase_ == Phase::kCoasting) ticks_ = 0;
    }
  }
  if (phase_ == Phase::kCoasting) {
    torque_N_m_.setZero();
    if (is_over(order_.coast_s, ++ticks_, period_s)) phase_ = Phase::kNone;
  } else if (active()) {
    command(angle, axes, period_s);
    if (phase_ == Phase::kDriving) ++driven_ticks_;
  }
  return torque_N_m_;
}

}  // namespace thimble::firmware
