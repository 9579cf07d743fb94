#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "firmware/core/steps.h"

namespace thimble::firmware {
namespace {

void show_arm(const Parts& parts, std::size_t index, const ArmInputs& input, ArmTelemetry& shown) noexcept {
  const State& state = parts.state;
  const ArmState& arm = state.arm[index];
  const bool armed = state.mode == Mode::kArmed;
  const bool led = arm.source != nullptr;  // by a guest
  shown.tip_m = arm.posture.tip_m;
  shown.tip_velocity_m_s = arm.tip_velocity_m_s;
  shown.god_object_m = armed ? state.touch[index].god_object_m : shown.tip_m;
  shown.rendered_N = armed && !led ? state.touch[index].force_N : Vec3::Zero();
  shown.contacts = armed && !led ? state.touch[index].contacts : std::uint8_t{0};
  shown.inside = armed && !led ? parts.sources.scene.renderer().inside(index) : 0;
  shown.force_N = arm.force_N;
  shown.joint_rad = arm.joint_rad;
  shown.current_A = arm.current_A;
  shown.counts = input.counts;
  shown.axes = static_cast<std::uint8_t>(arm.axes);
  shown.limiters = arm.limiters;
  if (armed && parts.sources.scene.renderer().is_put_off()) shown.limiters |= kLimitWork;
}

// Only of a tick with a record: nobody else reads them.
void show_windings(Parts& parts) noexcept {
  const float ambient_C = parts.params.get(Param::ambient);
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i)
    for (std::size_t j = 0; j < parts.state.arm[i].axes; ++j)
      parts.state.telemetry.arm[i].winding_C[j] = parts.state.arm[i].heat[j].winding_C(ambient_C);
}

void show_tick(Parts& parts, const Inputs& inputs, Conditions unmet) noexcept {
  const State& state = parts.state;
  Telemetry& t = parts.state.telemetry;
  t.tick = inputs.tick;
  t.time_us = inputs.time_us;
  t.tick_us = inputs.last_tick_us;
  t.worst_tick_us = std::max(t.worst_tick_us, inputs.last_tick_us);
  t.mode = state.mode;
  t.fault = state.fault;
  t.ramp = state.mode == Mode::kArmed ? state.force_ramp : 0.0F;
  t.unmet = unmet;
  t.arm_count = parts.setup.arm_count;
  t.moves_itself = state.guest;
  t.scene_sequence = parts.sources.scene.sequence();
  t.bounds = parts.sources.scene.renderer().counters();
  bool contact = false;
  float most_N = 0;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmTelemetry& shown = t.arm[i];
    show_arm(parts, i, inputs.arm[i], shown);
    const bool touches = state.mode == Mode::kArmed && state.arm[i].source == nullptr;
    const float force_N = std::sqrt(shown.force_N.squaredNorm());
    if (touches) t.peak_force_N = std::max(t.peak_force_N, force_N);
    if (shown.contacts == 0) continue;
    contact = true;
    most_N = std::max(most_N, force_N);
  }
  if (contact) t.mean_force_N += (most_N - t.mean_force_N) / static_cast<float>(++t.contact_ticks);
}

// Where something moves, gives way, is touched or holds a tip; else there is nothing to draw.
void take_picture(Parts& parts) noexcept {
  Picture* picture = parts.observers.picture.blank();
  if (picture == nullptr) return;
  const control::Renderer& renderer = parts.sources.scene.renderer();
  const std::span<const control::BodyState> bodies = renderer.bodies();
  std::copy(bodies.begin(), bodies.end(), picture->bodies.begin());
  picture->body_count = bodies.size();
  picture->tissue_count = renderer.tissue_views(picture->tissues);
  std::size_t planes = 0;
  std::uint64_t inside = 0;
  for (std::size_t arm = 0; arm < parts.setup.arm_count; ++arm) {
    const bool touches = parts.state.telemetry.arm[arm].contacts != 0;
    const std::size_t count = touches ? renderer.contact_normals(arm, picture->planes[arm]) : 0;
    picture->plane_count[arm] = static_cast<std::uint8_t>(count);
    planes += count;
    inside |= picture->inside[arm] = parts.state.telemetry.arm[arm].inside;
  }
  if (picture->body_count + picture->tissue_count + planes != 0 || inside != 0)
    parts.observers.picture.send();
}

link::Levels levels(const Inputs& inputs, std::size_t arms) noexcept {
  link::Levels levels;
  levels.dead_man = inputs.dead_man;
  levels.e_stop = inputs.e_stop;
  for (std::size_t i = 0; i < arms; ++i) {
    levels.index[i] = inputs.arm[i].index;
    levels.drive_fault[i] = inputs.arm[i].drive_fault;
  }
  return levels;
}

link::RecordingArm recorded(const ArmState& arm) noexcept {
  link::RecordingArm to;
  to.homed = arm.homed;
  to.joints = static_cast<std::uint8_t>(arm.axes);
  for (std::size_t j = 0; j < arm.axes; ++j) {
    const MotorHeat::State heat = arm.heat[j].state();
    to.raw[j] = arm.encoder[j].raw();
    to.counts[j] = arm.encoder[j].counts();
    to.winding_K[j] = heat.winding_K;
    to.housing_K[j] = heat.housing_K;
    to.charge_A2_s[j] = heat.charge_A2_s;
    to.time_s[j] = heat.time_s;
  }
  return to;
}

// Everything that outlives a tick goes into the start record, or begins anew.
void start_recording(Parts& parts, const Inputs& inputs, Conditions unmet) noexcept {
  const State& state = parts.state;
  const SceneSource& scene = parts.sources.scene;
  if (!executes(Command::kRecord, state.mode, unmet) || scene.sequence() == 0 || scene.waiting()) return;
  RecordingStart start;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    if (!state.arm[i].seen || state.arm[i].age_ticks != 0) return;
    start.arms[i] = recorded(state.arm[i]);
  }
  start.start.tick = static_cast<std::uint32_t>(state.tick);
  start.start.period_s = parts.setup.period_s;
  start.start.mode = state.mode;
  start.start.levels = levels(inputs, parts.setup.arm_count);
  start.start.arms = parts.setup.arm_count;
  start.start.work_units = parts.setup.work_units;
  reset_to(parts, start);
  parts.observers.recorder.begin(start);
}

void record_tick(Parts& parts, const Inputs& inputs, Command executed, const Mark* mark) noexcept {
  const State& state = parts.state;
  Recorder::Tick tick;
  tick.tick = inputs.tick;
  tick.arms = parts.setup.arm_count;
  std::array<float, 3 * kMaxArms> forces_N{};
  for (std::size_t i = 0; i < kMaxArms; ++i) {
    tick.counts[i] = std::span(inputs.arm[i].counts).first(state.arm[i].axes);
    for (std::size_t j = 0; j < state.arm[i].axes; ++j)
      tick.wide[i] = tick.wide[i] || parts.setup.arm[i].data().axis[j].counter_bits > 16;
    std::copy_n(state.arm[i].force_N.data(), 3, forces_N.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  tick.forces = std::as_bytes(std::span(forces_N).first(std::size_t{3} * parts.setup.arm_count));
  tick.mode = state.mode;
  tick.command = static_cast<link::RecordedCommand>(executed);
  tick.levels = levels(inputs, parts.setup.arm_count);
  tick.faulted = state.fault != Fault::kNone;
  tick.mark = mark;
  parts.observers.recorder.tick(tick);
}

}  // namespace

void publish(Parts& parts, const Inputs& inputs, Command executed, std::optional<Command> command,
             const Mark* mark) noexcept {
  State& state = parts.state;
  Observers& observers = parts.observers;
  const Conditions unmet = unmet_conditions(parts, inputs);
  show_tick(parts, inputs, unmet);
  const bool record_due = observers.records.due(parts.params.get_unsigned(Param::telemetry_decimation));
  if (record_due) show_windings(parts);
  observers.freeze.add(state.telemetry);
  observers.records.add(state.telemetry, record_due);
  if (record_due && (state.mode != Mode::kArmed || state.source->needs().scene)) take_picture(parts);
  parts.sources.move.publish();
  parts.sources.axes.publish();
  parts.status.publish(state, unmet, unmet_for_move(parts, unmet));
  if (observers.recorder.running()) {
    record_tick(parts, inputs, executed, mark);
  } else if (command == Command::kRecord) {
    start_recording(parts, inputs, unmet);
  }
}

}  // namespace thimble::firmware
