// One tick of the controller. A reader starts here: the steps in order, each in a file of its own in this folder.
#include <optional>

#include "firmware/core/core.h"
#include "firmware/core/steps.h"

namespace thimble::firmware {

Core::Core(const Config& config, const Params& params) noexcept : parts_(config, params) {
  if (parts_.setup.arm_count != 0) return;
  trip(parts_, Fault::bad_config);
  parts_.status.publish(parts_.state, kBadConfig | kFaultLatched, kNotArmed);
}

namespace {

// The level of the event line in this tick. What stopped the arm has ended the pulse before; a mark of the same tick still has its edge.
bool event_line(const Setup& setup, State& state, bool marked) noexcept {
  if (marked) state.pulse_ticks = setup.pulse_ticks;
  if (state.pulse_ticks == 0) return false;
  --state.pulse_ticks;
  return true;
}

}  // namespace

Outputs Core::tick(const Inputs& inputs) noexcept {
  Parts& parts = parts_;
  const State& state = parts.state;
  const std::optional<Command> taken = parts.commands.take();
  const Mark* const mark = parts.marks.mark();
  if (mark != nullptr && mark->kind == link::MarkKind::kTrial)
    parts.sources.scene.set_trial(static_cast<std::uint8_t>(mark->value));

  sense(parts, inputs);
  // What was ordered before the loop stood still is not wanted any more: its host has given up, and a hand may be anywhere.
  const bool late = state.lost > parts.params.get_unsigned(Param::lost_ticks);
  const bool yields = taken && (((state.disarm_ordered || late) && yields_to_disarm(*taken)) ||
                                (state.stop_ordered && yields_to_stop(*taken)));
  const std::optional<Command> command = yields ? std::nullopt : taken;
  const Command executed = decide(parts, inputs, command);
  if (state.mode == Mode::kArmed) {
    const SourceOutcome outcome = apply_source(parts);
    if (outcome.good) limit_forces(parts, outcome);
  }
  if (state.mode == Mode::kDamping) brake(parts);  // also when the source has just tripped
  if (state.mode != Mode::kArmed) end_guest(parts);
  Outputs outputs;
  drive(parts, outputs);
  outputs.event = event_line(parts.setup, parts.state, mark != nullptr);
  publish(parts, inputs, executed, command, mark);

  outputs.mode = state.mode;
  if (mark != nullptr) parts.marks.done(state.tick);
  if (taken) parts.commands.done();
  return outputs;
}

void Core::begin_with(const MotorsHeat& heat) noexcept {
  for (std::size_t i = 0; i < parts_.setup.arm_count; ++i)
    for (std::size_t j = 0; j < parts_.state.arm[i].axes; ++j)
      parts_.state.arm[i].heat[j].resume(
          {.winding_K = heat[i][j].winding_K, .housing_K = heat[i][j].housing_K});
}

void Core::begin_with(Fault fault) noexcept {
  if (parts_.setup.arm_count == 0) return;  // bad_config is
  trip(parts_, fault);
  parts_.status.publish(parts_.state, kNotHomed | kEncoderStale | kNoScene | kFaultLatched, kNotArmed);
}

void Core::resume(const RecordingStart& start, std::uint8_t trial) noexcept {
  parts_.sources.scene.adopt();
  parts_.sources.scene.set_trial(trial);
  parts_.state.tick = start.start.tick;
  parts_.state.first_tick = false;
  reset_to(parts_, start);
}

}  // namespace thimble::firmware
