// A contact that keeps people safe (e-stop, dead-man switch), freed of its bounce. Towards the safe side, open, it acts at
// once and on the shortest opening; towards the other it waits until the contact has stayed closed for a while.
// Once a tick, servo context. No heap, no OS; cannot fail.
#pragma once

#include <cstdint>

namespace thimble::board {

class SafeContact {
 public:
  // settle_ticks: samples in a row that must be closed before it counts as closed; at least 1. It starts open.
  explicit SafeContact(std::uint32_t settle_ticks) noexcept
      : settle_ticks_(settle_ticks < 1 ? 1 : settle_ticks) {}

  // closed: the level now; opened: it was open at any time since the last call. Returns whether it counts as closed.
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
