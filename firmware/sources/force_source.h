// Where forces come from: one interface for the scene, the host, guarded moves and whatever comes next. A source says what force each
// arm is to exert; ramp, clamp, slew limit, motor limits and telemetry come behind it and are the same for all.
//
// A source is either
//   the source of all arms   chosen when the arm is armed: the first row of the table (sources.h) that is wanted() then
//   a guest                  leads one arm while the source of all arms goes on with the others; it is started by a command, and its
//                            arm's force is not ramped, because it begins from the force that it finds
// A new source is one file that derives from ForceSource, one row in sources.h, and one test (tests/unit/firmware/source_test.cpp shows
// one). All but wanted() is called by the tick: O(1) or a named bound, no heap, lock, exception or I/O. Units: SI, world frame.
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

// What a source needs of the rest, and what follows from its giving the forces.
struct SourceNeeds {
  const char* name;
  bool scene =
      false;  // without a scene, arming is refused; the forces fade out and in while scenes are swapped
  bool host = false;         // a host that is silent for host_timeout_s is the fault host_lost
  float host_timeout_s = 0;  // 0: the parameter link_timeout
  // Why a recording ends when the source takes an arm; kNotYet: the recorded counts determine its forces.
  link::RecordingEnd ends_recording = link::RecordingEnd::kNotYet;
};

// What a source sees of a tick.
struct SourceTick {
  const Setup& setup;
  const Params& params;
  std::uint64_t tick;
  std::span<const ArmState> arms;  // the arms that there are
};

// What a source gives, for each arm: the force, a point to show as the god object, the number of contacts to show. An arm that it does
// not lead, it leaves alone.
struct SourceForces {
  std::span<control::Touch> arms;
  std::uint8_t clamped = 0;  // bit n: the source itself limited the force of arm n
  bool let_go = false;       // the arm must not be led on: it is disarmed
};

class ForceSource {
 public:
  explicit constexpr ForceSource(const SourceNeeds& needs) noexcept : needs_(needs) {}
  ForceSource(const ForceSource&) = delete;
  ForceSource& operator=(const ForceSource&) = delete;

  [[nodiscard]] const SourceNeeds& needs() const noexcept { return needs_; }

  // To be the source of all arms. It depends on the parameters alone, and is called from both contexts.
  [[nodiscard]] virtual bool wanted(const Params& params) const noexcept = 0;
  // The arms are armed, with this source or another: contacts, orders and the like begin anew.
  virtual void start(const SourceTick& tick) noexcept = 0;
  // Once a tick while it leads an arm. A force that is not finite is the fault force_not_finite.
  virtual void forces(const SourceTick& tick, SourceForces& out) noexcept = 0;

 protected:
  ~ForceSource() = default;

 private:
  SourceNeeds needs_;
};

}  // namespace thimble::firmware
