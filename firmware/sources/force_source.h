// Where forces come from: one interface for the scene, the host and guarded moves. A source says what force each arm is to exert. Ramp,
// clamp, slew limit, motor limits and telemetry follow, and are the same for all sources.
//
// A source is either
//   the source of all arms   chosen when the arm is armed: the first row of the table (sources.h) that is wanted() then
//   a guest                  leads one arm, while the source of all arms gives the forces of the others. A command starts it. Its
//                            force is not ramped, because it starts from the present force
// A new source is a class that derives from ForceSource, a row in sources.h, and a test: docs/extending.md lists the files, and
// tests/unit/firmware/source_test.cpp has an example. The tick calls every function except wanted(), which both contexts call: O(1) or a
// named bound, no heap, lock, exception or I/O. Units: SI, world frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "control/renderer_types.h"
#include "firmware/core/setup.h"
#include "firmware/core/state.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"
#include "firmware/params.h"

namespace thimble::firmware {

// What a source needs, and what follows when it gives the forces.
struct SourceNeeds {
  const char* name;
  bool scene =
      false;  // without a scene, arming is refused; the forces fade out and in while scenes are swapped
  bool host = false;         // a host that is silent for host_timeout_s is the fault host_lost
  float host_timeout_s = 0;  // 0: the parameter link_timeout
  // The reason with which a recording ends when the source starts. kNotYet: it does not end, because the recorded counts determine the
  // forces of this source.
  link::RecordingEnd ends_recording = link::RecordingEnd::kNotYet;
};

// What a source sees of a tick.
struct SourceTick {
  const Setup& setup;
  const Params& params;
  std::uint64_t tick;
  std::span<const ArmState> arms;  // of the arms in use
};

// What a source gives for each arm: the force, a point to show as the god object, the number of contacts to show. A source writes only
// the entries of the arms that it leads.
struct SourceForces {
  std::span<control::Touch> arms;
  std::uint8_t clamped = 0;  // bit n: the source itself limited the force of arm n
  bool let_go = false;       // the source cannot continue: the arms are disarmed
};

class ForceSource {
 public:
  explicit constexpr ForceSource(const SourceNeeds& needs) noexcept : needs_(needs) {}
  ForceSource(const ForceSource&) = delete;
  ForceSource& operator=(const ForceSource&) = delete;

  [[nodiscard]] const SourceNeeds& needs() const noexcept { return needs_; }

  // Whether it is to be the source of all arms. Depends on the parameters alone; called from both contexts.
  [[nodiscard]] virtual bool wanted(const Params& params) const noexcept = 0;
  // Called for every source when the arms are armed, with this source or another: reset contacts, force commands and the like.
  virtual void start(const SourceTick& tick) noexcept = 0;
  // Called once a tick while the source leads an arm. A force that is not finite raises the fault force_not_finite.
  virtual void forces(const SourceTick& tick, SourceForces& out) noexcept = 0;

 protected:
  ~ForceSource() = default;

 private:
  SourceNeeds needs_;
};

}  // namespace thimble::firmware
