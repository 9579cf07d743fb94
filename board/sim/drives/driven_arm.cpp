#include "board/sim/drives/driven_arm.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace thimble::board::emulated {
namespace {

constexpr std::uint64_t kArmStep_us = 100;  // of the arm's simulation, in substeps of its own
constexpr std::uint64_t kWatched_us = 100'000;
constexpr double kSomeTorque_N_m = 1e-4;

}  // namespace

DrivenArm::DrivenArm(const PlantVariant& variant, const HandPath& path, std::vector<EmulatedDrive*> drives)
    : plant_(PlantParameters::from(variant), Hand{}),
      path_(path),
      drives_(std::move(drives)),
      last_rotors_rad_(plant_.rotors_rad()) {
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
  const kinematics::ArmData& arm = plant_.parameters().model;
  Vector3d current_A = Vector3d::Zero();
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    const double torque_N_m = drives_[j]->torque_N_m();
    if (!since_s_ && std::abs(torque_N_m) > kSomeTorque_N_m) since_s_ = plant_.time_s();
    current_A[static_cast<int>(j)] =
        torque_N_m / static_cast<double>(arm.axis[j].motor.torque_constant_N_m_A);
  }
  const HandPath::Sample hand = path_.at(path_.start_s() + (since_s_ ? plant_.time_s() - *since_s_ : 0));
  plant_.set_hand_target(hand.position_m, since_s_ ? hand.velocity_m_s : Vector3d::Zero());
  plant_.command_current(current_A, true);  // a drive without power gives no torque
  plant_.step(seconds);
  const Vector3d moved_rad = plant_.rotors_rad() - last_rotors_rad_;
  last_rotors_rad_ = plant_.rotors_rad();
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    const double ratio = static_cast<double>(arm.axis[j].drive_turns * arm.axis[j].drive_sign);
    drives_[j]->shaft.position_rad = ratio * last_rotors_rad_[static_cast<int>(j)];
    drives_[j]->shaft.velocity_rad_s = ratio * moved_rad[static_cast<int>(j)] / seconds;
  }
}

void DrivenArm::watch(std::uint64_t now_us, std::uint64_t frames) {
  const auto one_follows = [](const EmulatedDrive* one) { return one->follows(); };
  const bool follows = std::ranges::any_of(drives_, one_follows);
  // Not the frame that switches one off.
  if (frames != frames_ && std::ranges::all_of(drives_, one_follows)) {
    command_us_ = now_us;
    tip_m_ = plant_.tip_m();
  }
  frames_ = frames;
  const double travel_m = (plant_.tip_m() - tip_m_).norm();
  if (followed_ && !follows) {
    off_us_ = now_us;
    held_m_ = travel_m_ = travel_m;
    speed_m_s_ = 0;
  }
  followed_ = follows;
  if (off_us_ == 0) return;
  travel_m_ = std::max(travel_m_, travel_m);
  speed_m_s_ = std::max(speed_m_s_, plant_.tip_velocity_m_s().norm());
  if (now_us < off_us_ + kWatched_us) return;
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "{\"off_after_ms\": %.2f, \"travel_till_off_mm\": %.3f, \"travel_mm\": %.3f, \"speed_m_s\": %.3f}",
      static_cast<double>(off_us_ - command_us_) * 1e-3, held_m_ * 1e3, travel_m_ * 1e3, speed_m_s_);
  report_ = text.data();
  off_us_ = 0;
  since_s_.reset();  // the hand lets go, and begins anew with the next torque
}

std::optional<std::string> DrivenArm::take_report() { return std::exchange(report_, std::nullopt); }

}  // namespace thimble::board::emulated
