// Marks: writes of the parameters `event` and `trial`. Each is taken by one tick, which is told to the host that wrote (Marked of messages.def)
// and to a recording (RecordingMark). In that tick the event line rises, and a trial's force fields act from then on.
//
// A tick takes one mark at most. The background posts the next one when the last one has been taken, so each has a tick of its own.
#pragma once

#include <cstdint>

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/word.h"
#include "firmware/link/messages.h"

namespace thimble::firmware {

// How long the event line stays active after the last mark, and at least a tick: what samples it at 100 Hz or more sees it, and an
// amplifier at 250 Hz sees it twice. A mark within that time extends the pulse: its own edge would have to wait for a later tick.
inline constexpr float kEventPulse_s = 0.01F;

struct Mark {
  link::MarkKind kind;
  std::uint16_t value;
  std::uint16_t before;  // the parameter's value until then
};

class Marks {
 public:
  // --- background
  // False: no tick has taken the last one yet.
  [[nodiscard]] bool post(const Mark& mark) noexcept {
    Mark* place = mark_.blank();
    if (place == nullptr) return false;
    *place = mark;
    mark_.send();
    return true;
  }
  [[nodiscard]] bool pending() const noexcept { return mark_.sent(); }
  // Low 32 bits of the tick that took the last one; once it is not pending any more.
  [[nodiscard]] std::uint32_t tick() const noexcept { return tick_.get(); }

  // --- tick
  [[nodiscard]] const Mark* mark() const noexcept { return mark_.letter(); }
  void done(std::uint64_t tick) noexcept {
    tick_.set(static_cast<std::uint32_t>(tick));
    mark_.done();
  }

 private:
  Mailbox<Mark> mark_;
  Value<std::uint32_t> tick_;
};

}  // namespace thimble::firmware
