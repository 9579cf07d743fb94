// The ForceOrder and WrenchOrder frames of a host that renders: passed to the tick, and counted (HostOrders). A frame has an
// effect only while the parameter host_forces is 1 and the controller is armed.
//
// Who calls it: the controller, in the background context.
#pragma once

#include "firmware/core/core.h"
#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "firmware/params.h"

namespace thimble::firmware {

class ForceOrders {
 public:
  ForceOrders(Core& core, const Params& params, std::uint8_t node, std::uint8_t arm_count) noexcept
      : core_(core), params_(params), node_(node), arm_count_(arm_count) {}

  bool on_frame(const link::CanFrame& frame, link::Micros now) noexcept;  // false: not such a frame
  [[nodiscard]] link::HostOrders counts() const noexcept;

 private:
  [[nodiscard]] bool force_of(const link::CanFrame& frame, link::ForceOrder& order) const noexcept;

  Core& core_;
  const Params& params_;
  std::uint8_t node_;
  std::uint8_t arm_count_;
  link::HostOrders counts_;  // but for the expired ones, which the tick counts
};

}  // namespace thimble::firmware
