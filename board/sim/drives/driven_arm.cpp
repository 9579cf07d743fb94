#include "board/sim/drives/driven_arm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace thimble::board::emulated {
namespace {

constexpr std::uint64_t kArmStep_us = 100;  // of the arm's simulation, in substeps of its own
constexpr std::uint64_t kWatched_us = 100'000;
constexpr double kSomeTorque_N_m = 1e-4;
constexpr double kAwaited_s = .5;  // longer than an ODrive is on for its position
// Of what the hand feels: over the probes of encoders (encoder_probe.h), each of which takes up to a tenth of the force for a moment.
constexpr double kSmooth_s = .5;

}  // namespace

std::size_t DrivenArm::motors_of(const kinematics::ArmData& arm) {
  return static_cast<std::size_t>(std::ranges::count(arm.geometry.driven, true));
}

DrivenArm::DrivenArm(const SimArm& arm, const HandPath& path, std::vector<EmulatedDrive*> drives)
    : arm_(arm),
      path_(path),
      drives_(std::move(drives)),
      last_rotors_rad_(arm_.rotors_rad()),
      tip_now_m_(arm_.tip_m()),
      felt_at_m_(tip_now_m_) {
  axes_.reserve(drives_.size());
  for (std::size_t j = 0; j < arm_.axes(); ++j)
    if (arm_.data().geometry.driven.at(j)) axes_.push_back(j);
  for (EmulatedDrive* drive : drives_) drive->shaft.moves = false;
}

void DrivenArm::advance(std::uint64_t now_us, std::uint64_t frames) {
  if (now_us_ == 0) now_us_ = now_us;
  while (now_us_ + kArmStep_us <= now_us) {
    now_us_ += kArmStep_us;
    step(kArmStep_us * 1e-6);
  }
  watch(now_us, frames);
}

void DrivenArm::step(double seconds) {
  const kinematics::ArmData& data = arm_.data();
  const bool on = std::ranges::all_of(drives_, [](const EmulatedDrive* one) { return one->follows(); });
  if (!on) on_since_s_.reset();
  if (on && !on_since_s_) on_since_s_ = arm_.time_s();
  if (!since_s_ && on && arm_.time_s() - *on_since_s_ > kAwaited_s) since_s_ = arm_.time_s();
  SimArm::PerAxis current_A = SimArm::PerAxis::Zero();
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    const double torque_N_m = drives_[k]->torque_N_m();
    if (!since_s_ && std::abs(torque_N_m) > kSomeTorque_N_m) since_s_ = arm_.time_s();
    current_A[static_cast<Eigen::Index>(axes_[k])] =
        torque_N_m / static_cast<double>(data.axis[axes_[k]].motor.torque_constant_N_m_A);
  }
  const HandPath::Sample hand = path_.at(path_.start_s() + (since_s_ ? arm_.time_s() - *since_s_ : 0));
  arm_.set_hand_target(hand.position_m, since_s_ ? hand.velocity_m_s : Vector3d::Zero());
  arm_.command_current(current_A, true);  // a drive without power gives no torque
  arm_.step(seconds, false);
  const SimArm::PerAxis moved_rad = arm_.rotors_rad() - last_rotors_rad_;
  last_rotors_rad_ = arm_.rotors_rad();
  for (std::size_t k = 0; k < drives_.size(); ++k) {
    const kinematics::AxisData& axis = data.axis[axes_[k]];
    const auto ratio = static_cast<double>(axis.drive_turns * axis.drive_sign);
    const auto at = static_cast<Eigen::Index>(axes_[k]);
    drives_[k]->shaft.position_rad = ratio * last_rotors_rad_[at];
    drives_[k]->shaft.velocity_rad_s = ratio * moved_rad[at] / seconds;
  }
  tip_now_m_ = arm_.tip_m();
  felt_N_ += seconds / kSmooth_s * (arm_.hand_force_N() - felt_N_);
  felt_at_m_ += seconds / kSmooth_s * (tip_now_m_ - felt_at_m_);
}

void DrivenArm::watch(std::uint64_t now_us, std::uint64_t frames) {
  const auto one_follows = [](const EmulatedDrive* one) { return one->follows(); };
  const bool follows = std::ranges::any_of(drives_, one_follows);
  // Not the frame that switches one off.
  if (frames != frames_ && std::ranges::all_of(drives_, one_follows)) {
    command_us_ = now_us;
    tip_m_ = tip_now_m_;
    reported_N_ = felt_N_;
    reported_at_m_ = felt_at_m_;
  }
  frames_ = frames;
  const double travel_m = (tip_now_m_ - tip_m_).norm();
  if (followed_ && !follows) {
    off_us_ = now_us;
    held_m_ = travel_m_ = travel_m;
    speed_m_s_ = 0;
  }
  followed_ = follows;
  if (off_us_ == 0) return;
  travel_m_ = std::max(travel_m_, travel_m);
  speed_m_s_ = std::max(speed_m_s_, arm_.tip_velocity_m_s().norm());
  if (now_us < off_us_ + kWatched_us) return;
  const Vector3d tip_mm = 1e3 * reported_at_m_;
  std::array<char, 320> text{};
  std::snprintf(
      text.data(), text.size(),
      "{\"off_after_ms\": %.2f, \"travel_till_off_mm\": %.3f, \"travel_mm\": %.3f, \"speed_m_s\": %.3f, "
      "\"hand_N\": [%.4f, %.4f, %.4f], \"tip_mm\": [%.3f, %.3f, %.3f]}",
      static_cast<double>(off_us_ - command_us_) * 1e-3, held_m_ * 1e3, travel_m_ * 1e3, speed_m_s_,
      reported_N_.x(), reported_N_.y(), reported_N_.z(), tip_mm.x(), tip_mm.y(), tip_mm.z());
  report_ = text.data();
  off_us_ = 0;
  since_s_.reset();  // the hand lets go, and begins anew with the next torque
}

std::optional<std::string> DrivenArm::take_report() { return std::exchange(report_, std::nullopt); }

}  // namespace thimble::board::emulated
