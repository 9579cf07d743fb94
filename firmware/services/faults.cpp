// Services 14 (clear faults) and 19 (read faults and their freeze frames).
#include <algorithm>
#include <bit>

#include "firmware/services/handlers.h"

namespace thimble::firmware {
namespace {

constexpr std::uint8_t kCount = 0x01, kList = 0x02, kFreezeFrames = 0x04;  // reports of service 19
constexpr std::uint8_t kAllFreezeFrames = 0xFF;

static_assert(std::all_of(std::begin(kFaultTable), std::end(kFaultTable),
                          [](const FaultRow& row) { return static_cast<unsigned>(row.fault) < 32; }),
              "faults_seen() has 32 bits");

struct SeenFault {
  std::uint8_t number = 0;  // of firmware/core/faults.def
  std::uint8_t status = 0;  // kFaultActive | kFaultConfirmed
};

// Takes the lowest fault out of the bits, which are not 0.
[[nodiscard]] SeenFault take_fault(std::uint32_t& seen, Fault latched) noexcept {
  const auto number = static_cast<std::uint8_t>(std::countr_zero(seen));
  seen &= seen - 1;
  const bool active = number == static_cast<std::uint8_t>(latched);
  return {number, static_cast<std::uint8_t>(link::kFaultConfirmed | (active ? link::kFaultActive : 0U))};
}

// A fault as the three bytes of a trouble code.
void put_fault(link::ByteWriter& answer, std::uint8_t number) noexcept {
  answer.put(0);
  answer.put(0);
  answer.put(number);
}

[[nodiscard]] link::FreezeFrame to_record(const FrozenTick& tick, std::size_t arm_number) noexcept {
  const FrozenArm& arm = tick.arm[arm_number];
  link::FreezeFrame frame;
  frame.tick = static_cast<std::uint32_t>(tick.tick);
  frame.arm = static_cast<std::uint8_t>(arm_number);
  frame.mode = tick.mode;
  frame.limiters = arm.limiters;
  frame.contacts = arm.contacts;
  for (std::size_t joint = 0; joint < link::kFrozenJoints; ++joint) {
    frame.counts[joint] = static_cast<std::int32_t>(arm.counts[joint]);
    frame.current_A[joint] = arm.current_A[static_cast<int>(joint)];
  }
  frame.tip_x_m = arm.tip_m.x();
  frame.tip_y_m = arm.tip_m.y();
  frame.tip_z_m = arm.tip_m.z();
  frame.force_x_N = arm.force_N.x();
  frame.force_y_N = arm.force_N.y();
  frame.force_z_N = arm.force_N.z();
  return frame;
}

[[nodiscard]] link::FreezeJoints other_joints(const FrozenArm& arm) noexcept {
  link::FreezeJoints joints;
  for (std::size_t j = 0; j < joints.counts.size(); ++j) {
    const std::size_t joint = link::kFrozenJoints + j;
    joints.counts[j] = static_cast<std::int32_t>(arm.counts[joint]);
    joints.current_A[j] = arm.current_A[static_cast<int>(joint)];
  }
  return joints;
}

struct FrozenRecords {
  link::FreezeFrame frame;
  link::FreezeJoints others;
  bool has_others = false;
};

// Freeze frame `index`, 0 the oldest: those of all arms, tick by tick; when they are more than the link shows, the newest.
[[nodiscard]] bool freeze_frame(const ServiceParts& parts, std::size_t index,
                                FrozenRecords& frozen) noexcept {
  const std::size_t arms = parts.config.arm_count;
  const std::size_t frames = parts.core.observers().freeze.count() * arms;
  if (index >= std::min(frames, link::kMaxFreezeFrames)) return false;
  if (frames > link::kMaxFreezeFrames) index += frames - link::kMaxFreezeFrames;
  FrozenTick tick;
  if (!parts.core.observers().freeze.tick(index / arms, tick)) return false;
  const FrozenArm& arm = tick.arm[index % arms];
  frozen = {to_record(tick, index % arms), other_joints(arm), arm.axes > link::kFrozenJoints};
  return true;
}

[[nodiscard]] Nrc list_faults(const ServiceParts& parts, Call& call, bool count_only) noexcept {
  if (call.request.size() != 3) return Nrc::kIncorrectLength;
  const std::uint8_t mask = call.request[2];
  call.answer.put(link::kFaultActive | link::kFaultConfirmed);
  std::uint16_t matches = 0;
  for (std::uint32_t seen = parts.core.status().faults_seen(); seen != 0;) {
    const SeenFault fault = take_fault(seen, parts.core.status().fault());
    if ((fault.status & mask) == 0) continue;
    ++matches;
    if (count_only) continue;
    put_fault(call.answer, fault.number);
    call.answer.put(fault.status);
  }
  if (count_only) {
    call.answer.put(0x01);  // the codes are formatted by ISO 14229-1
    call.answer.put_u16(matches);
  }
  return Nrc::kOk;
}

[[nodiscard]] Nrc freeze_frames(const ServiceParts& parts, Call& call) noexcept {
  if (call.request.size() != 6) return Nrc::kIncorrectLength;
  const std::uint8_t number = call.request[4];
  const std::uint8_t which = call.request[5];
  if (call.request[2] != 0 || call.request[3] != 0) return Nrc::kRequestOutOfRange;
  for (std::uint32_t seen = parts.core.status().faults_seen(); seen != 0;) {
    const SeenFault fault = take_fault(seen, parts.core.status().fault());
    if (fault.number != number) continue;
    put_fault(call.answer, number);
    call.answer.put(fault.status);
    // Only the fault that is latched has its ticks kept.
    const std::size_t most = (fault.status & link::kFaultActive) != 0 ? link::kMaxFreezeFrames : 0;
    FrozenRecords frozen;
    for (std::size_t i = 0; i < most && freeze_frame(parts, i, frozen); ++i) {
      const auto frame_number = static_cast<std::uint8_t>(i + 1);
      if (which != kAllFreezeFrames && which != frame_number) continue;
      call.answer.put(frame_number);
      const bool others =
          frozen.has_others && which != kAllFreezeFrames;  // all of them do not fit in an answer
      call.answer.put(others ? 2 : 1);                     // data identifiers in it
      call.answer.put_u16(link::FreezeFrame::kId);
      call.answer.put_record(frozen.frame);
      if (!others) continue;
      call.answer.put_u16(link::FreezeJoints::kId);
      call.answer.put_record(frozen.others);
    }
    return Nrc::kOk;
  }
  return Nrc::kRequestOutOfRange;
}

}  // namespace

Nrc clear_faults(Services& services, Call& call) noexcept {
  if (call.request.size() != 4) return Nrc::kIncorrectLength;
  const bool all = call.request[1] == 0xFF && call.request[2] == 0xFF && call.request[3] == 0xFF;
  if (!all) return Nrc::kRequestOutOfRange;
  return services.jobs.run(call, services.command, [&]() noexcept {
    services.parts.audit.asked(Audit::Asked::kClear, call.host, call.now_us);
    return services.command.begin(call, Command::kClear);
  });
}

Nrc read_faults(Services& services, Call& call) noexcept {
  if (call.request.size() < 2) return Nrc::kIncorrectLength;
  const std::uint8_t report = call.sub_function();
  call.answer.put(report);
  switch (report) {
    case kCount:
    case kList:
      return list_faults(services.parts, call, report == kCount);
    case kFreezeFrames:
      return freeze_frames(services.parts, call);
    default:
      return Nrc::kSubFunctionNotSupported;
  }
}

}  // namespace thimble::firmware
