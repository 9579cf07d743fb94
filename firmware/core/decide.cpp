#include <algorithm>

#include "firmware/core/steps.h"

namespace thimble::firmware {
namespace {

constexpr float kRampUp_s = 0.2F;     // after arming and after a scene swap
constexpr float kRampDown_s = 0.05F;  // before a scene swap

void home_arms(Parts& parts, const Inputs& inputs) noexcept {
  State& state = parts.state;
  if (state.mode != Mode::kHoming) return;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    const kinematics::Arm<float>& geometry = parts.setup.arm[i];
    const ArmInputs& input = inputs.arm[i];
    if (arm.homed || arm.age_ticks != 0 || (parts.setup.has_index[i] && !input.index)) continue;
    for (std::size_t j = 0; j < arm.axes; ++j) {
      arm.encoder[j].home(input.counts[j], geometry.home()[static_cast<int>(j)]);
      arm.speed[j].reset(0);
    }
    arm.joint_rad = geometry.home();
    geometry.move_to(arm.joint_rad, arm.posture);
    arm.tip_velocity_m_s.setZero();
    arm.in_workspace = true;
    arm.homed = true;
  }
  if (all_homed(parts.setup, state)) {
    happen(parts, Event::kAllHomed);
  } else if (state.mode_time_s > parts.params.get(Param::homing_timeout)) {
    trip(parts, Fault::homing_timeout);
  }
}

// One arm is where a host says; the others know their homes already. Where it cannot be there, nobody knows where it is.
void home_at(Parts& parts, const Inputs& inputs, const link::HomePlace& place) noexcept {
  State& state = parts.state;
  ArmState& arm = state.arm[place.arm];
  const kinematics::Arm<float>& geometry = parts.setup.arm[place.arm];
  constexpr std::uint32_t kPeriods = 64;  // it may have moved since the host read the registers
  parts.observers.recorder.end(RecordingEnd::kPlaced);
  if (arm.age_ticks != 0) {
    lose_home(arm);
    return;
  }
  for (std::size_t j = 0; j < arm.axes; ++j) {
    kinematics::JointEncoder& encoder = arm.encoder[j];
    const auto axis = static_cast<int>(j);
    encoder.resume(place.raw[j], place.counts[j], geometry.home()[axis]);
    if (encoder.update(inputs.arm[place.arm].counts[j], kPeriods) != kinematics::EncoderStatus::kOk) {
      lose_home(arm);
      return;
    }
    arm.speed[j].reset(encoder.counts());
    arm.joint_rad[axis] = encoder.angle_rad();
  }
  geometry.move_to(arm.joint_rad, arm.posture);
  arm.tip_velocity_m_s.setZero();
  arm.in_workspace = geometry.limit(arm.joint_rad) == 0;
  arm.homed = true;
  if (!all_homed(parts.setup, state)) return;
  happen(parts, Event::kHomeCommand);
  happen(parts, Event::kAllHomed);
}

// Out of line on every board: a rule of tests/hardware/cortex/firmware.limits is about it.
[[gnu::noinline]] void arm_with_source(Parts& parts) noexcept {
  State& state = parts.state;
  happen(parts, Event::kArmCommand);
  state.force_ramp = state.gravity_ramp = 0;
  state.source = &parts.sources.wanted(parts.params);
  parts.observers.recorder.end(state.source->needs().ends_recording);
  parts.sources.start_all(source_tick(parts));
  start_limits(parts);
  for (ArmState& arm : state.arm) {
    for (EncoderWatch& watch : arm.watch) watch.reset();
    arm.probe.reset();
    arm.given = 1;
    arm.speed_watch.reset();
  }
}

// Orders of guests whose command is not carried out.
void forget_orders(Sources& sources) noexcept {
  if (sources.move.ordered() != nullptr) sources.move.forget_order();
  if (sources.axes.ordered() != nullptr) sources.axes.forget_order();
}

// The guest whose order came with the command. One that leads another arm, or the other guest, ends.
void start_guest(Parts& parts, Conditions unmet) noexcept {
  Sources& sources = parts.sources;
  const link::AxisOrder* axes = sources.axes.ordered();
  const MoveOrder* move = sources.move.ordered();
  if (axes == nullptr && move == nullptr) return;
  if (unmet_for_move(parts, unmet) != 0) {
    forget_orders(sources);
    return;
  }
  const bool leads_axes = axes != nullptr;
  ArmState& arm = parts.state.arm[leads_axes ? axes->arm : move->arm];
  const auto begin = [&](auto& guest) noexcept {
    if (arm.source != &guest) {
      if (arm.source == nullptr && parts.state.guest) parts.state.force_ramp = 0;  // of the arm it led
      end_guest(parts);
    }
    arm.source = &guest;
    parts.observers.recorder.end(guest.needs().ends_recording);
    guest.begin(source_tick(parts));
  };
  if (leads_axes) {
    begin(sources.axes);
  } else {
    begin(sources.move);
  }
  arm.led_N_m = leads_axes ? &sources.axes.torque_N_m() : nullptr;
  for (EncoderWatch& watch : arm.watch) watch.forget_torques();
  parts.state.guest = true;
}

void clear_fault(Parts& parts) noexcept {
  parts.state.fault = Fault::kNone;
  parts.state.faults_seen = 0;
  parts.observers.freeze.clear();
  happen(parts, Event::kClearCommand);
}

[[gnu::cold, gnu::noinline]] void execute(Parts& parts, const Inputs& inputs, Command command,
                                          Conditions unmet) noexcept {
  State& state = parts.state;
  // An order whose command was replaced by another one.
  if (command != Command::kMove) forget_orders(parts.sources);
  if (!executes(command, state.mode, unmet)) return;
  switch (command) {
    case Command::kHome:
      if (const link::HomePlace* place = parts.commands.placed()) {
        home_at(parts, inputs, *place);
        return;
      }
      for (ArmState& arm : state.arm) arm.homed = false;
      happen(parts, Event::kHomeCommand);
      return;
    case Command::kArm:
      arm_with_source(parts);
      return;
    case Command::kDisarm:  // of a replay; of a host it comes as Commands::disarms(), too
      happen(parts, Event::kDisarmCommand, StoppedBy::kDisarm);
      return;
    case Command::kClear:
      clear_fault(parts);
      return;
    case Command::kMove:
      start_guest(parts, unmet);
      return;
    case Command::kEndMove:
      if (!state.guest) return;
      end_guest(parts);
      state.force_ramp = 0;  // the scene's force comes back as after arming
      return;
    case Command::kNone:
    case Command::kStop:    // comes as Commands::stops()
    case Command::kRecord:  // at the end of the tick: publish()
      return;
  }
}

// Takes the scene that the background posted. While armed with forces of a scene, the old one fades out first and the new one in. Other materials
// come at once: a force falls with them, and rises from where it is as the account of the limits lets it.
void swap_scenes(Parts& parts) noexcept {
  State& state = parts.state;
  SceneSource& scene = parts.sources.scene;
  const bool waiting = scene.waiting();
  if (waiting) parts.observers.recorder.end(RecordingEnd::kScene);
  if (state.mode == Mode::kArmed) {
    const bool fades = scene.waits_to_fade() && state.source->needs().scene;
    const float step = fades ? -parts.setup.period_s / kRampDown_s : parts.setup.period_s / kRampUp_s;
    state.force_ramp = std::clamp(state.force_ramp + step, 0.0F, 1.0F);
    state.gravity_ramp = std::min(state.gravity_ramp + parts.setup.period_s / kRampUp_s, 1.0F);
    if (fades && state.force_ramp > 0.0F) return;
  }
  if (!waiting) return;
  scene.take();
  for (ArmState& arm : state.arm) arm.limits.another_scene();
  state.telemetry.contact_ticks = 0;
  state.telemetry.peak_force_N = 0;
  state.telemetry.mean_force_N = 0;
}

}  // namespace

Command decide(Parts& parts, const Inputs& inputs, std::optional<Command> command) noexcept {
  State& state = parts.state;
  home_arms(parts, inputs);
  Command executed = state.stop_ordered ? Command::kStop : Command::kNone;
  if (state.disarm_ordered) {
    const Mode before = state.mode;
    happen(parts, Event::kDisarmCommand, StoppedBy::kDisarm);
    if (state.mode != before) executed = Command::kDisarm;
  }
  if (command) {
    const Mode before = state.mode;
    execute(parts, inputs, *command, unmet_conditions(parts, inputs));
    if (state.mode != before) executed = *command;  // a command that changed nothing is not recorded
  }
  if (state.mode == Mode::kArmed && !inputs.dead_man) happen(parts, Event::kLetGo, StoppedBy::kDeadMan);
  swap_scenes(parts);
  return executed;
}

}  // namespace thimble::firmware
