// The forces that a host orders, on their way to the tick: what is felt instead of the scene while the parameter
// host_forces is 1. Owned by the servo; docs/host-rendering.md is the user's side of it.
//
//   background  order(): the newest order of each arm replaces the one before, also one that no tick has seen
//   servo       forget() when it arms, then take() once a tick and arm
//
// An order is in force for kLife_s, counted in ticks (lost ones included) from the tick that took it; then it has
// expired. Frames may be repeated or overtake one another: an order whose number is not after that of the last one
// taken is passed over, unless that one has expired, for then a new program may have begun to count.
//
// The handover never waits: a version that is odd while the words change. A tick that meets one, or sees the version
// change under it, keeps the order that it has and looks again in the next tick. Units: N, world frame. Cannot fail.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "control/scene/limits.h"
#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

class HostForces {
 public:
  static constexpr float kLife_s = 0.02F;

  explicit HostForces(float period_s) noexcept;

  // --- background. arm < control::kMaxArms. False: it was passed over.
  [[nodiscard]] bool order(const link::ForceOrder& order, link::Micros now) noexcept;
  // Orders that expired since start.
  [[nodiscard]] std::uint32_t expired() const noexcept { return expired_.load(std::memory_order_relaxed); }

  // --- servo
  // What has been ordered until now does not count.
  void forget() noexcept;
  // The order that is in force in this tick; null: none.
  [[nodiscard]] const Vec3* take(std::size_t arm, std::uint64_t tick) noexcept;

  [[nodiscard]] std::uint32_t life_ticks() const noexcept { return life_ticks_; }

 private:
  struct Arm {
    // The background's.
    link::Micros ordered_us = 0;
    std::uint8_t sequence = 0;
    bool ordered = false;
    // Handed over: mN as they travel, x in the lower half of the first word.
    std::atomic<std::uint32_t> version{0};
    std::array<std::atomic<std::uint32_t>, 2> words{};
    // The tick's.
    std::uint32_t seen = 0;  // the version
    bool in_force = false;
    std::uint64_t taken_tick = 0;
    Vec3 force_N = Vec3::Zero();
  };

  std::array<Arm, control::kMaxArms> arms_;
  std::uint32_t life_ticks_;
  std::atomic<std::uint32_t> expired_{0};
};

}  // namespace thimble::firmware
