#include "firmware/sources/axis_source.h"

#include <algorithm>
#include <cmath>

namespace thimble::firmware {

AxisSource::AxisSource() noexcept
    : ForceSource({.name = "axes",
                   .host = true,
                   .host_timeout_s = link::kMoveHostTimeout_s,
                   .ends_recording = link::RecordingEnd::kGuardedMove}) {}

bool AxisSource::post(const link::AxisOrder& order) noexcept {
  link::AxisOrder* blank = orders_.blank();
  if (blank == nullptr) return false;
  *blank = order;
  orders_.send();
  return true;
}

link::AxisState AxisSource::state() const noexcept {
  link::AxisState state;
  state.phase = phase_.get();
  state.end = end_.get();
  state.begin_tick = begin_tick_.get();
  state.driven_ticks = driven_ticks_.get();
  return state;
}

void AxisSource::begin(const SourceTick& tick) noexcept {
  const link::AxisOrder* order = orders_.letter();
  if (order == nullptr) return;
  begin_tick_.set(static_cast<std::uint32_t>(tick.tick));
  drive_.start(*order, tick.arms[order->arm].joint_rad);
  orders_.done();
}

// No axis pushes the tip with more than max_force. An axis that hardly moves the tip has the lever kLeastLever_m.
void AxisSource::forces(const SourceTick& tick, SourceForces& out) noexcept {
  constexpr float kLeastLever_m = 0.02F;
  const std::size_t index = drive_.arm();
  const ArmState& arm = tick.arms[index];
  const kinematics::Arm<float>& geometry = tick.setup.arm[index];
  Axes& torque_N_m = drive_.tick(arm.joint_rad, geometry.axes(), tick.setup.period_s);
  const float max_N = std::min(tick.params.get(Param::max_force), geometry.data().max_force_N);
  for (int j = 0; j < geometry.axes(); ++j) {
    const float lever_m = std::sqrt(arm.posture.jacobian.col(j).squaredNorm());
    const float most_N_m = max_N * std::max(lever_m, kLeastLever_m);
    if (std::isfinite(torque_N_m[j]) && std::abs(torque_N_m[j]) > most_N_m)
      torque_N_m[j] = std::copysign(most_N_m, torque_N_m[j]);
  }
  out.arms[index] = {Vec3::Zero(), arm.posture.tip_m, 0};
  out.let_go = !drive_.active();
}

void AxisSource::tell() noexcept {
  end_.set(drive_.end());
  driven_ticks_.set(drive_.driven_ticks());
  phase_.set(drive_.phase());
}

}  // namespace thimble::firmware
