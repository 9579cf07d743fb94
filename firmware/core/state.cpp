// What changes the state from several steps: events, faults, and the start of a recording.
#include "firmware/core/state.h"

#include <algorithm>

#include "firmware/core/steps.h"

namespace thimble::firmware {

ArmState::ArmState(const kinematics::Arm<float>& arm, float period_s) noexcept
    : axes(static_cast<std::size_t>(arm.axes())),
      redundant(std::ranges::count(arm.data().geometry.driven, true) > 3),
      joint_rad(arm.home()),
      posture(arm.home_posture()) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    encoder[j] = kinematics::JointEncoder(arm.data().axis[j], arm.data().max_joint_speed_rad_s, period_s);
    speed[j] = kinematics::VelocityEstimator(period_s);
  }
}

void happen(Parts& parts, Event event, StoppedBy by) noexcept {
  State& state = parts.state;
  const Mode next = next_mode(state.mode, event, all_homed(parts.setup, state));
  if (next == state.mode) return;
  if (state.mode == Mode::kArmed) {
    state.stopped_by = by;
    state.pulse_ticks = 0;
  }
  state.mode = next;
  state.mode_time_s = 0;
}

void trip(Parts& parts, Fault reason) noexcept {
  State& state = parts.state;
  const FaultRow* row = find_fault(reason);
  state.faults_seen |= 1U << static_cast<unsigned>(reason);
  if (state.fault == Fault::kNone) {
    state.fault = reason;
    state.pulse_ticks = 0;
    state.fault_tick = static_cast<std::uint32_t>(state.tick);
    ++state.telemetry.trips;
  }
  const bool damps = row != nullptr && row->reaction == Reaction::kDamp;
  happen(parts, damps ? Event::kTripDamp : Event::kTripZero,
         reason == Fault::host_stop ? StoppedBy::kStop : StoppedBy::kFault);
}

void reset_to(Parts& parts, const RecordingStart& start) noexcept {
  State& state = parts.state;
  parts.sources.scene.restart();
  state.touch = {};
  state.in_contact = false;
  state.mode = start.start.mode == Mode::kReady ? Mode::kReady : Mode::kDisarmed;
  state.mode_time_s = state.force_ramp = state.gravity_ramp = 0;
  state.link_age_ticks = 0;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    const kinematics::Arm<float>& geometry = parts.setup.arm[i];
    const link::RecordingArm& from = start.arms[i];
    for (std::size_t j = 0; j < arm.axes; ++j) {
      const auto axis = static_cast<int>(j);
      arm.encoder[j].resume(from.raw[j], from.counts[j], geometry.home()[axis]);
      arm.speed[j].reset(from.counts[j]);
      arm.watch[j].reset();
      arm.heat[j].resume({from.winding_K[j], from.housing_K[j], from.charge_A2_s[j], from.time_s[j]});
      arm.joint_rad[axis] = arm.encoder[j].angle_rad();
    }
    arm.probe.reset();
    arm.speed_watch.reset();
    arm.seen = true;
    arm.homed = from.homed;
    arm.sample_tick = state.tick;
    arm.age_ticks = 0;
    geometry.move_to(arm.joint_rad, arm.posture);
    arm.in_workspace = geometry.limit(arm.joint_rad) == 0;
    arm.tip_velocity_m_s.setZero();
    arm.force_N.setZero();
    arm.torque_N_m.setZero();
    arm.current_A.setZero();
  }
}

}  // namespace thimble::firmware
