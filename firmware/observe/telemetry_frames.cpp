#include "firmware/observe/telemetry_frames.h"

#include <algorithm>
#include <array>
#include <utility>

#include "firmware/link/messages.h"

namespace thimble::firmware {
namespace {

constexpr std::uint64_t kRateWindow_us = 500'000;

// The opt-in frames of an arm, in their order; those of more joints than a frame has come in parts.
constexpr std::array kDetails = {link::kContentOrientation, link::kContentJointAngles,
                                 link::kContentMotorCurrents, link::kContentTemperatures};
constexpr std::size_t kJointsAFrame = 3, kTemperaturesAFrame = 6;

constexpr std::size_t joints_a_frame(unsigned content) noexcept {
  return content == link::kContentTemperatures ? kTemperaturesAFrame : kJointsAFrame;
}

}  // namespace

bool TelemetryFrames::fetch() noexcept {
  bool any = false;
  for (std::size_t i = 0; i < TelemetryRecords::kRecords && core_.observers().records.next(record_); ++i) {
    any = true;
    ++sequence_;
    for (std::size_t arm = 0; arm < record_.arm_count; ++arm) limiters_ |= record_.arm[arm].limiters;
    worst_tick_us_ = std::max(worst_tick_us_, record_.tick_us);
    const auto time_us = static_cast<std::uint32_t>(record_.time_us - window_time_us_);  // of a second or so
    if (window_time_us_ == 0 || time_us >= kRateWindow_us) {
      if (window_time_us_ != 0)
        rate_Hz_ = static_cast<float>(static_cast<std::uint32_t>(record_.tick - window_tick_)) * 1e6F /
                   static_cast<float>(time_us);
      window_tick_ = record_.tick;
      window_time_us_ = record_.time_us;
    }
    dropped_ += tip_frames_left_;
    fd_ = params_.on(Param::telemetry_fd);
    content_ = params_.get_unsigned(Param::telemetry_content);
    tip_frames_left_ = static_cast<std::uint8_t>((fd_ ? 1 : 2) * record_.arm_count);
    detail_arm_ = fd_ ? record_.arm_count : std::uint8_t{0};
    detail_ = 0;
  }
  return any;
}

bool TelemetryFrames::next_tip_frame(link::CanFrame& frame) noexcept {
  if (tip_frames_left_ == 0) return false;
  if (fd_) {
    frame = record_frame(record_.arm_count - std::size_t{tip_frames_left_--});
    return true;
  }
  const std::size_t arm = record_.arm_count - static_cast<std::size_t>((tip_frames_left_ + 1) / 2);
  frame = tip_frames_left_ % 2 == 0 ? pose_frame(arm) : force_frame(arm);
  --tip_frames_left_;
  return true;
}

bool TelemetryFrames::next_detail_frame(link::CanFrame& frame) noexcept {
  for (; detail_arm_ < record_.arm_count; ++detail_arm_, detail_ = detail_part_ = 0) {
    if (detail_ == 0) {
      ++detail_;
      if (has_god_object(detail_arm_)) {
        frame = god_object_frame(detail_arm_);
        return true;
      }
    }
    while (detail_ <= kDetails.size()) {
      const unsigned content = kDetails[detail_ - 1U];
      if ((content_ & content) == 0 || !has_part(detail_arm_, content)) {
        ++detail_;
        detail_part_ = 0;
        continue;
      }
      frame = content == link::kContentOrientation ? orientation_frame(detail_arm_)
                                                   : joints_frame(detail_arm_, content);
      ++detail_part_;
      return true;
    }
  }
  return false;
}

bool TelemetryFrames::has_part(std::size_t arm, unsigned content) const noexcept {
  if (content == link::kContentOrientation) return detail_part_ == 0 && has_orientation(arm);
  return detail_part_ * joints_a_frame(content) < record_.arm[arm].axes;
}

bool TelemetryFrames::has_orientation(std::size_t arm) const noexcept {
  return core_.setup().arm[arm].has_orientation() && record_.arm[arm].joint_rad.allFinite();
}

// Otherwise it is the tip.
bool TelemetryFrames::has_god_object(std::size_t arm) const noexcept {
  return record_.arm[arm].contacts != 0 || record_.moves_itself;
}

template <class Message>
void TelemetryFrames::put_head(Message& message, std::size_t arm) const noexcept {
  message.arm = static_cast<std::uint8_t>(arm);
  message.contacts = record_.arm[arm].contacts;
  message.limiters = record_.arm[arm].limiters & 0xFU;  // there is room for four; Status has them all
  message.sequence = sequence_;
}

link::CanFrame TelemetryFrames::pose_frame(std::size_t arm) const noexcept {
  link::Pose pose;
  put_head(pose, arm);
  pose.x_m = record_.arm[arm].tip_m.x();
  pose.y_m = record_.arm[arm].tip_m.y();
  pose.z_m = record_.arm[arm].tip_m.z();
  return link::to_frame(pose, node_);
}

link::CanFrame TelemetryFrames::force_frame(std::size_t arm) const noexcept {
  link::Force force;
  put_head(force, arm);
  force.x_N = record_.arm[arm].force_N.x();
  force.y_N = record_.arm[arm].force_N.y();
  force.z_N = record_.arm[arm].force_N.z();
  return link::to_frame(force, node_);
}

link::CanFrame TelemetryFrames::god_object_frame(std::size_t arm) const noexcept {
  link::GodObject god;
  put_head(god, arm);
  god.x_m = record_.arm[arm].god_object_m.x();
  god.y_m = record_.arm[arm].god_object_m.y();
  god.z_m = record_.arm[arm].god_object_m.z();
  return link::to_frame(god, node_);
}

link::CanFrame TelemetryFrames::orientation_frame(std::size_t arm) const noexcept {
  const Eigen::Quaternionf q = core_.setup().arm[arm].orientation(record_.arm[arm].joint_rad);
  link::Orientation orientation;
  put_head(orientation, arm);
  orientation.x = q.x();
  orientation.y = q.y();
  orientation.z = q.z();
  return link::to_frame(orientation, node_);
}

link::CanFrame TelemetryFrames::joints_frame(std::size_t arm, unsigned content) const noexcept {
  const ArmTelemetry& shown = record_.arm[arm];
  const auto filled = [&](auto message, auto values, const auto& from) {
    message.arm = static_cast<std::uint8_t>(arm);
    message.part = detail_part_;
    message.sequence = sequence_;
    auto& to = message.*values;
    const std::size_t first = detail_part_ * joints_a_frame(content);
    std::copy_n(from.data() + first, std::min(to.size(), std::size_t{kJoints} - first), to.begin());
    return link::to_frame(message, node_);
  };
  if (content == link::kContentJointAngles)
    return filled(link::JointAngles{}, &link::JointAngles::angle_rad, shown.joint_rad);
  if (content == link::kContentMotorCurrents)
    return filled(link::MotorCurrents{}, &link::MotorCurrents::current_A, shown.current_A);
  return filled(link::Temperatures{}, &link::Temperatures::winding_C, shown.winding_C);
}

link::CanFrame TelemetryFrames::record_frame(std::size_t arm) const noexcept {
  const ArmTelemetry& shown = record_.arm[arm];
  link::ArmRecord record;
  put_head(record, arm);
  std::copy_n(shown.tip_m.data(), 3, record.tip_m.begin());
  std::copy_n(shown.force_N.data(), 3, record.force_N.begin());
  std::copy_n((has_god_object(arm) ? shown.god_object_m : shown.tip_m).data(), 3,
              record.god_object_m.begin());
  const bool oriented = (content_ & link::kContentOrientation) != 0 && has_orientation(arm);
  if (oriented)
    std::copy_n(core_.setup().arm[arm].orientation(shown.joint_rad).vec().data(), 3,
                record.orientation.begin());
  if ((content_ & link::kContentJointAngles) != 0)
    std::copy_n(shown.joint_rad.data(), kJoints, record.angle_rad.begin());
  if ((content_ & link::kContentMotorCurrents) != 0)
    std::copy_n(shown.current_A.data(), kJoints, record.current_A.begin());
  if ((content_ & link::kContentTemperatures) != 0)
    std::copy_n(shown.winding_C.data(), kJoints, record.winding_C.begin());
  link::CanFrame frame = link::to_frame(record, node_);
  const bool more = oriented || (content_ & (link::kContentJointAngles | link::kContentMotorCurrents |
                                             link::kContentTemperatures)) != 0;
  if (!more) frame.size = link::least_size<link::ArmRecord>();
  return frame;
}

std::uint8_t TelemetryFrames::take_limiters() noexcept { return std::exchange(limiters_, std::uint8_t{0}); }
float TelemetryFrames::take_worst_tick_us() noexcept { return std::exchange(worst_tick_us_, 0.0F); }

}  // namespace thimble::firmware
