// The freeze frame: the last kFreezeTicks ticks up to the tick of the fault, kept until the fault is cleared.
//
// The tick writes while no fault is latched, then sends the whole buffer to the background (Mailbox). It takes the buffer back when it
// executes the clear command, which the background posted: while a command is pending the background reads nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/modes.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/request.h"
#include "firmware/observe/telemetry.h"

namespace thimble::firmware {

inline constexpr std::size_t kFreezeTicks = 64;

// What is kept of a tick: a part of its Telemetry.
struct FrozenArm {
  Vec3 tip_m = Vec3::Zero(), force_N = Vec3::Zero();
  kinematics::PerAxis<float> current_A = kinematics::PerAxis<float>::Zero();
  std::array<std::uint32_t, kinematics::kMaxJoints> counts{};
  std::uint8_t axes = 0, contacts = 0, limiters = 0;
};
struct FrozenTick {
  std::uint64_t tick = 0;
  Mode mode = Mode::kDisarmed;
  Fault fault = Fault::kNone;
  std::array<FrozenArm, control::kMaxArms> arm{};
};

class FreezeFrame {
 public:
  explicit FreezeFrame(const Request<Command>& commands) noexcept : commands_(commands) {}

  // --- tick
  void add(const Telemetry& tick) noexcept {
    Buffer* buffer = box_.blank();
    if (buffer == nullptr) return;
    FrozenTick& kept = buffer->ticks[buffer->count++ % kFreezeTicks];
    kept.tick = tick.tick;
    kept.mode = tick.mode;
    kept.fault = tick.fault;
    for (std::size_t i = 0; i < tick.arm_count; ++i) keep(tick.arm[i], kept.arm[i]);
    if (buffer->count == 2 * kFreezeTicks) buffer->count = kFreezeTicks;
    if (tick.fault != Fault::kNone) box_.send();
  }
  void clear() noexcept {
    box_.recall();
    box_.blank()->count = 0;
  }

  // --- background
  [[nodiscard]] std::size_t count() const noexcept {  // 0 without a fault
    const Buffer* buffer = readable();
    return buffer == nullptr ? 0 : std::min<std::size_t>(buffer->count, kFreezeTicks);
  }
  // 0 the oldest. False: there is no such tick.
  [[nodiscard]] bool tick(std::size_t index, FrozenTick& tick) const noexcept {
    const std::size_t kept = count();
    if (index >= kept) return false;
    const Buffer& buffer = *readable();
    tick = buffer.ticks[(buffer.count - kept + index) % kFreezeTicks];
    return true;
  }

 private:
  static void keep(const ArmTelemetry& arm, FrozenArm& kept) noexcept {
    kept.tip_m = arm.tip_m;
    kept.force_N = arm.force_N;
    for (std::size_t j = 0; j < arm.axes; ++j) {
      const int axis = static_cast<int>(j);
      kept.current_A[axis] = arm.current_A[axis];
      kept.counts[j] = arm.counts[j];
    }
    kept.axes = arm.axes;
    kept.contacts = arm.contacts;
    kept.limiters = arm.limiters;
  }

  struct Buffer {
    std::array<FrozenTick, kFreezeTicks> ticks;
    std::uint32_t count = 0;  // of ticks, then counting on from kFreezeTicks
  };
  [[nodiscard]] const Buffer* readable() const noexcept {
    return commands_.pending() ? nullptr : box_.letter();
  }

  const Request<Command>& commands_;
  Mailbox<Buffer> box_;
};

}  // namespace thimble::firmware
