#include "firmware/services/force_orders.h"

namespace thimble::firmware {

// The force of a ForceOrder, or of a WrenchOrder without a torque: the arms can exert none.
bool ForceOrders::force_of(const link::CanFrame& frame, link::ForceOrder& order) const noexcept {
  if (link::from_frame(frame, node_, order)) return true;
  link::WrenchOrder wrench;
  if (!link::from_frame(frame, node_, wrench)) return false;
  if (wrench.torque_N_m != std::array<float, 3>{}) return false;
  order.arm = wrench.arm;
  order.sequence = wrench.sequence;
  order.x_N = wrench.force_N[0];
  order.y_N = wrench.force_N[1];
  order.z_N = wrench.force_N[2];
  return true;
}

bool ForceOrders::on_frame(const link::CanFrame& frame, link::Micros now) noexcept {
  if (frame.extended || frame.id != std::uint32_t{link::ForceOrder::kId} + node_) return false;
  if (!params_.on(Param::host_forces) || core_.status().mode() != Mode::kArmed) return true;
  link::ForceOrder order;
  if (!force_of(frame, order) || order.arm >= arm_count_) {
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
