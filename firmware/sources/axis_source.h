// Orders for the axes (axis_drive.h) as a force source: a guest that leads one arm while the others feel the scene. It gives no force at the tip, but
// the torques of the axes. Its orders come from the background.
#pragma once

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/word.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"
#include "firmware/sources/axis_drive.h"
#include "firmware/sources/force_source.h"

namespace thimble::firmware {

class AxisSource final : public ForceSource {
 public:
  AxisSource() noexcept;

  // --- background
  // The order of Command::kMove, before that is posted. False: the last order is still waiting.
  [[nodiscard]] bool post(const link::AxisOrder& order) noexcept;
  [[nodiscard]] link::AxisState state() const noexcept;

  // --- tick
  [[nodiscard]] bool wanted(const Params&) const noexcept override { return false; }  // a guest only
  void start(const SourceTick&) noexcept override {}
  void forces(const SourceTick& tick, SourceForces& out) noexcept override;

  [[nodiscard]] const link::AxisOrder* ordered() const noexcept { return orders_.letter(); }
  void begin(const SourceTick& tick) noexcept;  // the motion that is ordered()
  void forget_order() noexcept { orders_.done(); }
  void stop() noexcept { drive_.stop(); }
  // At the end of every tick; most ticks have nothing to tell.
  void publish() noexcept {
    if (drive_.active() || phase_.get() != link::AxisPhase::kNone) tell();
  }

  [[nodiscard]] bool under_way() const noexcept { return drive_.under_way(); }
  [[nodiscard]] bool follows() const noexcept { return drive_.follows(); }
  [[nodiscard]] const Axes& torque_N_m() const noexcept { return drive_.torque_N_m(); }

 private:
  void tell() noexcept;

  AxisDrive drive_;
  Mailbox<link::AxisOrder> orders_;
  // phase_ is set last: who reads it sees what belongs to it.
  Value<link::AxisEnd> end_{link::AxisEnd::kNotYet};
  Value<std::uint32_t> begin_tick_{0}, driven_ticks_{0};
  Signal<link::AxisPhase> phase_{link::AxisPhase::kNone};
};

}  // namespace thimble::firmware
