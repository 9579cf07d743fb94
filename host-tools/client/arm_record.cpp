#include "host-tools/client/arm_record.h"

#include <algorithm>
#include <array>
#include <span>

#include "firmware/link/messages.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

template <class Message>
Message with_head(const link::ArmRecord& record) {
  Message message;
  message.arm = record.arm;
  message.contacts = record.contacts;
  message.limiters = record.limiters;
  message.sequence = record.sequence;
  return message;
}

// Joint values in frames of `kEach`; a frame behind the first one only where a value is not 0.
template <class Message, std::size_t kEach>
void add_joints(const link::ArmRecord& record, std::span<const float> values,
                std::array<float, kEach> Message::*member, std::uint8_t node,
                std::vector<link::CanFrame>& out) {
  for (std::size_t first = 0; first < values.size(); first += kEach) {
    const std::span<const float> some = values.subspan(first, std::min(kEach, values.size() - first));
    if (first != 0 && std::ranges::all_of(some, [](float value) { return value == 0.0F; })) continue;
    Message message;
    message.arm = record.arm;
    message.part = static_cast<std::uint8_t>(first / kEach);
    message.sequence = record.sequence;
    std::ranges::copy(some, (message.*member).begin());
    out.push_back(link::to_frame(message, node));
  }
}

}  // namespace

std::vector<link::CanFrame> classic_frames(const link::CanFrame& frame, std::uint8_t node) {
  link::ArmRecord record;
  if (!frame.fd || !link::from_frame(frame, node, record)) return {frame};
  std::vector<link::CanFrame> out;
  const auto add = [&](auto message, float x, float y, float z, auto... members) {
    const std::array values = {x, y, z};
    std::size_t axis = 0;
    ((message.*members = values.at(axis++)), ...);
    out.push_back(link::to_frame(message, node));
  };
  add(with_head<link::Pose>(record), record.tip_m[0], record.tip_m[1], record.tip_m[2], &link::Pose::x_m,
      &link::Pose::y_m, &link::Pose::z_m);
  add(with_head<link::Force>(record), record.force_N[0], record.force_N[1], record.force_N[2],
      &link::Force::x_N, &link::Force::y_N, &link::Force::z_N);
  if (record.contacts != 0 || record.god_object_m != record.tip_m)
    add(with_head<link::GodObject>(record), record.god_object_m[0], record.god_object_m[1],
        record.god_object_m[2], &link::GodObject::x_m, &link::GodObject::y_m, &link::GodObject::z_m);
  if (frame.size > link::least_size<link::ArmRecord>()) {
    add_joints(record, record.angle_rad, &link::JointAngles::angle_rad, node, out);
    add_joints(record, record.current_A, &link::MotorCurrents::current_A, node, out);
    add_joints(record, record.winding_C, &link::Temperatures::winding_C, node, out);
  }
  return out;
}

}  // namespace thimble::host
