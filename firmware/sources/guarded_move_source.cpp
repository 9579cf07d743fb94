#include "firmware/sources/guarded_move_source.h"

namespace thimble::firmware {

GuardedMoveSource::GuardedMoveSource() noexcept
    : ForceSource({.name = "guarded_move",
                   .host = true,
                   .host_timeout_s = link::kMoveHostTimeout_s,
                   .ends_recording = link::RecordingEnd::kGuardedMove}) {
  results_.send();  // empty ones
}

bool GuardedMoveSource::post(const MoveOrder& order) noexcept {
  MoveOrder* blank = orders_.blank();
  if (blank == nullptr) return false;
  *blank = order;
  orders_.send();
  return true;
}

void GuardedMoveSource::begin(const SourceTick& tick) noexcept {
  const MoveOrder* order = orders_.letter();
  if (order == nullptr) return;
  results_.recall();
  move_.start(*order, tick.arms[order->arm].posture.tip_m, *results_.blank());
  orders_.done();
}

void GuardedMoveSource::forces(const SourceTick& tick, SourceForces& out) noexcept {
  const std::size_t index = move_.arm();
  const ArmState& arm = tick.arms[index];
  const LimitedForce force = move_.tick(tick.setup.arm[index], arm.joint_rad, arm.posture,
                                        arm.tip_velocity_m_s, arm.force_N, tick.setup.period_s);
  out.arms[index] = {force.value, move_.set_point_m(), 0};
  if (force.which) out.clamped |= static_cast<std::uint8_t>(1U << index);
  out.let_go = !move_.active() || !arm.in_workspace;
}

void GuardedMoveSource::publish() noexcept {
  if (!results_.sent() && !move_.under_way()) results_.send();
  end_.set(move_.end());
  phase_.set(move_.state());
}

}  // namespace thimble::firmware
