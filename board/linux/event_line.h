// The event line: a TTL output for a lab's amplifier or camera (firmware/core/marks.h says when it is active). Without a line it does nothing.
//
// Who calls it: the servo, after the outputs of its tick; at most one system call, and only where the level changes. The guardian's process
// has a copy, which it only switches off.
#pragma once

#include <memory>
#include <utility>

#include "board/linux/outputs.h"

namespace thimble::board {

class EventLine {
 public:
  // line: not active.
  void open(std::unique_ptr<SwitchOutput> line) noexcept { line_ = std::move(line); }

  // A level that could not be set is tried again in the next tick.
  void write(bool active) noexcept {
    if (line_ && active != active_ && line_->set(active)) active_ = active;
  }
  // Whatever it was: also of a board that cannot tell.
  void off() noexcept {
    if (line_) (void)line_->set(false);
    active_ = false;
  }

 private:
  std::unique_ptr<SwitchOutput> line_;
  bool active_ = false;
};

}  // namespace thimble::board
