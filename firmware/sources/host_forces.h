// The force commands of a host as a force source: the forces while the parameter host_forces is 1, instead of those of the scene.
// docs/host-rendering.md is the description for users. "Order" is the force command of one arm (frame ForceOrder).
//
//   background  order(): the newest order of an arm replaces the one before it, even if no tick has seen that one
//   tick        start() at arming: older orders are discarded; then forces() takes the newest order of each arm
//
// An order is valid for kLife_s, counted in ticks (lost ones included) from the tick that took it. Then it has expired, and the tip is
// damped. Frames may arrive twice or out of order: an order is ignored if its number does not follow that of the last one. Once the last
// one has expired, any number is accepted, because another program may have started to count.
//
// Units: N, world frame. Cannot fail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/exchange/snapshot.h"
#include "firmware/exchange/word.h"
#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "firmware/sources/force_source.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

class HostForces final : public ForceSource {
 public:
  static constexpr float kLife_s = 0.02F;

  explicit HostForces(float period_s) noexcept;

  // --- background. arm < kMaxArms. False: it was ignored.
  [[nodiscard]] bool order(const link::ForceOrder& order, link::Micros now) noexcept;
  // Orders that expired since start.
  [[nodiscard]] std::uint32_t expired() const noexcept { return expired_.get(); }

  // --- tick
  [[nodiscard]] bool wanted(const Params& params) const noexcept override;
  void start(const SourceTick& tick) noexcept override;
  void forces(const SourceTick& tick, SourceForces& out) noexcept override;
  // The order that is in force in this tick; null: none.
  [[nodiscard]] const Vec3* take(std::size_t arm, std::uint64_t tick) noexcept;

 private:
  using Force_mN =
      std::array<std::int16_t, 4>;  // x, y, z as they travel, and a zero that fills the second word

  struct Arm {
    // The background's.
    link::Micros ordered_us = 0;
    std::uint8_t sequence = 0;
    bool ordered = false;
    Snapshot<Force_mN> handed_over;
    // The tick's.
    bool in_force = false;
    std::uint64_t taken_tick = 0;
    Vec3 force_N = Vec3::Zero();
  };

  std::array<Arm, kMaxArms> arms_;
  std::uint32_t life_ticks_;
  Counter expired_;
};

}  // namespace thimble::firmware
