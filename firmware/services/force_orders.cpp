#include "firmware/services/force_orders.h"

namespace thimble::firmware {

bool ForceOrders::on_frame(const link::CanFrame& frame, link::Micros now) noexcept {
  if (frame.extended || frame.id != std::uint32_t{link::ForceOrder::kId} + node_) return false;
  if (!params_.on(Param::host_forces) || core_.status().mode() != Mode::kArmed) return true;
  link::ForceOrder order;
  if (!link::from_frame(frame, node_, order) || order.arm >= arm_count_) {
    ++counts_.wrong;
  } else if (!core_.sources().host.order(order, now)) {
    ++counts_.old;
  } else {
    ++counts_.taken;
    core_.commands().keep_alive();
  }
  return true;
}

link::HostOrders ForceOrders::counts() const noexcept {
  link::HostOrders counts = counts_;
  counts.expired = core_.sources().host.expired();
  return counts;
}

}  // namespace thimble::firmware
