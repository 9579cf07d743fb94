// Which host commands. One host at a time arms, homes, moves, uploads, restarts and sets what has an effect on the forces (the rows
// Needs::kLease of services.cpp, and write_data()); the others look. Stopping is anybody's.
//
// A command takes the lease where no other host has it. It lasts kTime_us after the last command. Of a host that has ordered the arm to be
// armed, to home or to move it lasts while it is armed or homing, until the place of the host ends. A host gives it back when it opens the default session or leaves.
//
// Background context.
#pragma once

#include "firmware/core/modes.h"
#include "firmware/link/can_frame.h"
#include "firmware/services/call.h"

namespace thimble::firmware {

class Lease {
 public:
  // Longer than the gaps between the commands of a program, as the blocks of an upload on a link that loses frames; short enough to wait
  // for. Below link::kHostTimeout_us.
  static constexpr link::Micros kTime_us = 1'500'000;

  enum class Taken : std::uint8_t { kYes, kNotYet, kWhileArmed };

  // For a command of this host, in this mode. orders_arm: to arm, home or move. kNotYet: another host has the lease, and it will end by itself; kWhileArmed: nobody knows when.
  [[nodiscard]] Taken take(const Host& host, link::Micros now, Mode mode, bool orders_arm) noexcept {
    if (const Host* other = holder(now, mode); other != nullptr && other != &host)
      return mode == Mode::kArmed ? Taken::kWhileArmed : Taken::kNotYet;
    orders_arm_ = orders_arm || (orders_arm_ && holder_ == &host);
    holder_ = &host;
    vanished_ = false;
    commanded_us_ = now;
    return Taken::kYes;
  }
  void end(const Host& host) noexcept {
    if (holder_ != &host) return;
    holder_ = nullptr;
    vanished_ = host.vanished;
  }
  // The last host that had it has vanished, and no other one has taken it since.
  [[nodiscard]] bool vanished() const noexcept { return vanished_; }
  // Null: nobody.
  [[nodiscard]] const Host* holder(link::Micros now, Mode mode) const noexcept {
    const bool active = orders_arm_ && (mode == Mode::kArmed || mode == Mode::kHoming);
    return active || now - commanded_us_ < kTime_us ? holder_ : nullptr;
  }

 private:
  const Host* holder_ = nullptr;
  link::Micros commanded_us_ = 0;
  bool orders_arm_ = false;
  bool vanished_ = false;
};

}  // namespace thimble::firmware
