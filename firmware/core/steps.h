// The steps of a tick, in the order in which tick.cpp calls them, and what they work on. Each step is a function over Parts, in a file
// of its own; it runs in the tick, and has no heap, lock, exception or I/O.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "firmware/core/commands.h"
#include "firmware/core/conditions.h"
#include "firmware/core/config.h"
#include "firmware/core/marks.h"
#include "firmware/core/modes.h"
#include "firmware/core/motors_heat.h"
#include "firmware/core/setup.h"
#include "firmware/core/state.h"
#include "firmware/core/status.h"
#include "firmware/observe/observers.h"
#include "firmware/params.h"
#include "firmware/sources/sources.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

struct Parts {
  // Out of line on every board: one rule of tests/hardware/cortex/firmware.limits is about it.
  [[gnu::noinline]] Parts(const Config& config, const Params& parameters) noexcept
      : setup(config),
        params(parameters),
        sources(setup.period_s, setup.work_units, config.sources),
        status(params, sources),
        commands(setup, params, status, sources),
        observers(commands.channel()),
        state(setup, sources.wanted(params)) {}

  const Setup setup;
  const Params& params;
  Sources sources;
  Status status;
  Commands commands;
  Marks marks;
  Observers observers;
  HeatExchange heat;
  State state;
};

// Sense: inputs to joints, tips and velocities; the thermal model; the host's signs of life. Raises the faults that the inputs show.
void sense(Parts& parts, const Inputs& inputs) noexcept;
void check_evidence(Parts& parts, std::size_t arm, const ArmInputs& input) noexcept;
void check_index(Parts& parts, std::size_t arm, const ArmInputs& input) noexcept;

// Decide: homing, the command, the dead-man switch, the next scene. The result is the mode of this tick. Returns the command that changed
// the mode, or kNone.
[[nodiscard]] Command decide(Parts& parts, const Inputs& inputs, std::optional<Command> command) noexcept;

// Force source: the forces that the arms are to exert, before ramp and limits. good is false after a fault, or when the source lets go
// of the arm (SourceForces::let_go).
struct SourceOutcome {
  bool good = false;
  std::uint8_t clamped = 0;  // bit n: the source limited the force of arm n
};
[[nodiscard]] SourceOutcome apply_source(Parts& parts) noexcept;
void end_guest(Parts& parts) noexcept;  // State::source gives every arm's force again

// Limits: ramp, clamp and slew limit; or, while damping, the brake in place of a source.
void start_limits(Parts& parts) noexcept;  // at arming
void limit_forces(Parts& parts, const SourceOutcome& outcome) noexcept;
void brake(Parts& parts) noexcept;

// Drive: forces to joint torques to motor currents; zero unless the motors are on.
void drive(Parts& parts, Outputs& outputs) noexcept;

// Publish: telemetry, the observers, then the status for the background. `executed` is what decide() returned; mark: that this tick takes, or
// null.
void publish(Parts& parts, const Inputs& inputs, Command executed, std::optional<Command> command,
             const Mark* mark) noexcept;

// --- used by several steps

// Raises a fault: nothing else does. In the same tick the motors brake the tip or go off, as the fault's reaction says.
void trip(Parts& parts, Fault reason) noexcept;
// Changes the mode as the table of modes.h says. `by`: of an event that ends kArmed.
void happen(Parts& parts, Event event, StoppedBy by = StoppedBy::kNothing) noexcept;
// The conditions that refuse arming in this tick, and those that refuse a guarded move.
[[nodiscard]] Conditions unmet_conditions(const Parts& parts, const Inputs& inputs) noexcept;
[[nodiscard]] Conditions unmet_for_move(const Parts& parts, Conditions unmet) noexcept;
// Sets the state that a recording starts with: all state is taken from the record or reset.
void reset_to(Parts& parts, const RecordingStart& start) noexcept;

// Its home position is not known any more.
inline void lose_home(ArmState& arm) noexcept { arm.homed = arm.seen = false; }

// The age of a sample that is not a fault yet: that of the parameter, but no more than the stop path allows a force that nothing renews.
[[nodiscard]] inline std::uint32_t stale_ticks(const Parts& parts) noexcept {
  return std::min(parts.params.get_unsigned(Param::encoder_stale_ticks), parts.setup.most_stale_ticks);
}

// Tests the squared norm, because the clamp computes it: it must not overflow.
template <int kSize>
[[nodiscard]] bool finite(const Eigen::Matrix<float, kSize, 1>& vector) noexcept {
  return std::isfinite(vector.squaredNorm());
}

[[nodiscard]] inline SourceTick source_tick(const Parts& parts) noexcept {
  return {parts.setup, parts.params, parts.state.tick,
          std::span(parts.state.arm).first(parts.setup.arm_count)};
}
// The time since the host's last sign of life.
[[nodiscard]] inline float host_silence_s(const Parts& parts) noexcept {
  return static_cast<float>(parts.state.link_age_ticks) * parts.setup.period_s;
}

}  // namespace thimble::firmware
