#include "firmware/observe/telemetry_frames.h"

#include <algorithm>
#include <utility>

#include "firmware/link/messages.h"

namespace thimble::firmware {
namespace {

constexpr std::uint64_t kRateWindow_us = 500'000;

}  // namespace

bool TelemetryFrames::fetch() noexcept {
  bool any = false;
  for (std::size_t i = 0; i < TelemetryRecords::kRecords && core_.observers().records.next(record_); ++i) {
    any = true;
    ++sequence_;
    for (std::size_t arm = 0; arm < record_.arm_count; ++arm) limiters_ |= record_.arm[arm].limiters;
    worst_tick_us_ = std::max(worst_tick_us_, record_.tick_us);
    const std::uint64_t time_us = record_.time_us - window_time_us_;
    if (window_time_us_ == 0 || time_us >= kRateWindow_us) {
      if (window_time_us_ != 0)
        rate_Hz_ = static_cast<float>(record_.tick - window_tick_) * 1e6F / static_cast<float>(time_us);
      window_tick_ = record_.tick;
      window_time_us_ = record_.time_us;
    }
    dropped_ += tip_frames_left_;
    tip_frames_left_ = static_cast<std::uint8_t>(2 * record_.arm_count);
    god_object_arm_ = 0;
  }
  return any;
}

bool TelemetryFrames::next_tip_frame(link::CanFrame& frame) noexcept {
  if (tip_frames_left_ == 0) return false;
  const std::size_t arm = record_.arm_count - static_cast<std::size_t>((tip_frames_left_ + 1) / 2);
  frame = tip_frames_left_ % 2 == 0 ? pose_frame(arm) : force_frame(arm);
  --tip_frames_left_;
  return true;
}

link::CanFrame TelemetryFrames::pose_frame(std::size_t arm) const noexcept {
  link::Pose pose;
  pose.x_m = record_.arm[arm].tip_m.x();
  pose.y_m = record_.arm[arm].tip_m.y();
  pose.z_m = record_.arm[arm].tip_m.z();
  pose.arm = static_cast<std::uint8_t>(arm);
  pose.sequence = sequence_;
  return link::to_frame(pose, node_);
}

link::CanFrame TelemetryFrames::force_frame(std::size_t arm) const noexcept {
  const ArmTelemetry& shown = record_.arm[arm];
  link::Force force;
  force.x_N = shown.force_N.x();
  force.y_N = shown.force_N.y();
  force.z_N = shown.force_N.z();
  force.contacts = shown.contacts;
  force.limiters = shown.limiters;
  force.arm = static_cast<std::uint8_t>(arm);
  force.sequence = sequence_;
  return link::to_frame(force, node_);
}

bool TelemetryFrames::next_god_object_frame(link::CanFrame& frame) noexcept {
  while (god_object_arm_ < record_.arm_count) {
    const std::uint8_t arm = god_object_arm_++;
    const ArmTelemetry& shown = record_.arm[arm];
    if (shown.contacts == 0 && !record_.moves_itself) continue;  // the god object is the tip
    const link::GodObject god{shown.god_object_m.x(), shown.god_object_m.y(), shown.god_object_m.z(), arm,
                              sequence_};
    frame = link::to_frame(god, node_);
    return true;
  }
  return false;
}

std::uint8_t TelemetryFrames::take_limiters() noexcept { return std::exchange(limiters_, std::uint8_t{0}); }
float TelemetryFrames::take_worst_tick_us() noexcept { return std::exchange(worst_tick_us_, 0.0F); }

}  // namespace thimble::firmware
