// The core of the controller: what happens in one tick, from encoder counts to motor currents, with the modes, faults and limits.
// firmware/core/tick.cpp shows the steps in order. Owned by Controller, which boards call; controller.h states the two contexts.
//
//   encoders -> kinematics -> force source -> ramp, clamp, slew -> Jacobian transpose + gravity -> currents, thermal
#pragma once

#include "control/renderer.h"
#include "firmware/core/steps.h"

namespace thimble::firmware {

class Core {
 public:
  Core(const Config& config, const Params& params) noexcept;
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  // --- tick. Work: O(one tick of the force source), no heap, lock, exception or I/O.
  [[nodiscard]] Outputs tick(const Inputs& inputs) noexcept;
  [[nodiscard]] const Telemetry& telemetry() const noexcept { return parts_.state.telemetry; }
  [[nodiscard]] const Setup& setup() const noexcept { return parts_.setup; }
  [[nodiscard]] const control::Renderer& renderer() const noexcept { return parts_.sources.scene.renderer(); }

  // --- background: use only the functions of a part that its header lists under "background".
  [[nodiscard]] Commands& commands() noexcept { return parts_.commands; }
  [[nodiscard]] const Commands& commands() const noexcept { return parts_.commands; }
  [[nodiscard]] const Status& status() const noexcept { return parts_.status; }
  [[nodiscard]] Sources& sources() noexcept { return parts_.sources; }
  [[nodiscard]] const Sources& sources() const noexcept { return parts_.sources; }
  [[nodiscard]] Observers& observers() noexcept { return parts_.observers; }
  [[nodiscard]] const Observers& observers() const noexcept { return parts_.observers; }
  [[nodiscard]] Marks& marks() noexcept { return parts_.marks; }
  [[nodiscard]] const Marks& marks() const noexcept { return parts_.marks; }
  [[nodiscard]] HeatExchange& heat() noexcept { return parts_.heat; }
  // Before the first tick: the motors are not cold; something happened before this start.
  void begin_with(const MotorsHeat& heat) noexcept;
  void begin_with(Fault fault) noexcept;
  // For a replay, before the first tick: sets the state and the trial that a recording began with, and takes the scene that was posted last. The
  // recorded inputs and commands then give the recorded forces.
  void resume(const RecordingStart& start, std::uint8_t trial) noexcept;

 private:
  Parts parts_;
};

}  // namespace thimble::firmware
