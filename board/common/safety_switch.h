// Debounces a safety switch (e-stop, dead-man switch). An opening, which is the safe state, takes effect at
// once, also if it is shorter than a tick. A closing takes effect after the contact has stayed closed for
// settle_ticks. Called once per tick in the tick context. No heap, no OS; cannot fail.
#pragma once

#include <cstdint>

namespace thimble::board {

class SafetySwitch {
 public:
  // settle_ticks: number of consecutive closed samples after which it counts as closed; at least 1. It starts
  // open.
  explicit SafetySwitch(std::uint32_t settle_ticks) noexcept
      : settle_ticks_(settle_ticks < 1 ? 1 : settle_ticks) {}

  // closed: the present level; opened: it was open at some time since the last call. Returns whether it
  // counts as closed.
  bool update(bool closed, bool opened) noexcept {
    if (!closed || opened) {
      closed_ticks_ = 0;
    } else if (closed_ticks_ < settle_ticks_) {
      ++closed_ticks_;
    }
    return closed_ticks_ == settle_ticks_;
  }

 private:
  std::uint32_t settle_ticks_;
  std::uint32_t closed_ticks_ = 0;
};

}  // namespace thimble::board
