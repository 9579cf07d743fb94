#include "board/linux/arm_devices.h"

#include <algorithm>
#include <utility>

namespace thimble::board {

ArmDevices::ArmDevices(std::vector<ArmParts> arms, std::unique_ptr<DriveSet> drives, ServoBeat& beat)
    : beat_(beat), drives_(std::move(drives)) {
  arms_.reserve(arms.size());
  for (ArmParts& parts : arms) arms_.push_back({std::move(parts), {}});
}

void ArmDevices::read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept {
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    Arm& arm = arms_[i];
    const auto sample = arm.parts.encoders ? arm.parts.encoders->read(now_ns) : std::nullopt;
    if (sample) {
      // A latch within the last period belongs to this tick, an older one to an earlier tick.
      const std::uint64_t age_ns = sample->time_ns < now_ns ? now_ns - sample->time_ns : 0;
      std::ranges::copy(sample->counts, arm.last.counts.begin());
      arm.last.sample_tick = in.tick - std::min(in.tick, age_ns / period_ns);
    }
    in.arm[i].counts = arm.last.counts;
    in.arm[i].sample_tick = arm.parts.needs_encoders ? arm.last.sample_tick : in.tick;
    in.arm[i].drive_fault = beat_.cut() || arm.write_failed;
  }
  if (drives_) {
    if (beat_.cut()) drives_->cut();
    drives_->read(in, now_ns, period_ns);
  }
}

bool ArmDevices::write_arm(Arm& arm, const firmware::ArmOutputs& wanted, bool works) noexcept {
  if (!arm.parts.needs_dac) return works;
  ArmParts& parts = arm.parts;
  works = works && parts.dac && parts.enable;
  std::array<float, kArmJoints> current_A{};
  if (wanted.enable) std::copy_n(wanted.current_A.begin(), current_A.size(), current_A.begin());
  if (parts.dac && !parts.dac->write(current_A)) works = false;
  const bool enable = wanted.enable && works;
  if (parts.enable && enable != arm.enabled) {
    if (parts.enable->set(enable)) {
      arm.enabled = enable;
    } else {
      works = false;
      if (parts.dac) (void)parts.dac->zero();
    }
  }
  return works;
}

void ArmDevices::write(const firmware::Outputs& out, bool works, std::uint64_t now_ns) noexcept {
  bool all = true;
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    Arm& arm = arms_[i];
    firmware::ArmOutputs wanted = out.arm[i];
    wanted.enable = wanted.enable && !beat_.cut();
    if (drives_ && drives_->drives_arm(i))
      for (float& current_A : wanted.current_A) current_A *= drives_->gain();
    const bool worked = write_arm(arm, wanted, works);
    arm.write_failed = !worked;
    all = all && worked;
  }
  if (drives_) drives_->write(out, all && !beat_.cut(), now_ns);
}

void ArmDevices::switch_off() noexcept {
  for (Arm& arm : arms_) {
    if (arm.parts.enable && arm.parts.enable->set(false)) arm.enabled = false;
    if (arm.parts.dac) (void)arm.parts.dac->zero();
  }
  if (drives_) drives_->send_off();
}

void ArmDevices::forget() noexcept {
  if (drives_) drives_->stop();
}

}  // namespace thimble::board
