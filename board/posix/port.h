// One way from a board to its hosts: a pty, a TCP port, a serial port or a CAN interface.
//
// Who calls it: LinkPorts, for the board's background context; one thread. Once it is made nothing here blocks or throws: a host that
// leaves, a cable that is pulled and an interface that goes down are waited out, and the port goes on when they are back. The heap is
// used.
#pragma once

#include <poll.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/link/can_frame.h"

namespace thimble::board {

class Port {
 public:
  Port() = default;
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  virtual ~Port() = default;

  // How a host on this machine reaches it, the best first; none where the host's end has a name of its own.
  [[nodiscard]] virtual std::vector<std::string> uris() const = 0;

  virtual void add_to(std::vector<pollfd>& polled) const = 0;  // what is worth waking up for
  virtual void read() = 0;                                     // takes in what has come
  // The next frame of what was taken in.
  [[nodiscard]] virtual std::optional<firmware::link::CanFrame> receive() = 0;
  // To every host on this port, now or with a later flush(). Real-time frames (11-bit ids) that cannot leave soon are dropped.
  virtual void send(const firmware::link::CanFrame& frame) = 0;
  virtual void flush() = 0;
  [[nodiscard]] virtual bool waiting() const = 0;           // for a flush(), though nothing polled may say so
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;  // frames
  // What stands against sending at present, one sentence without its end; empty: nothing.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
};

}  // namespace thimble::board
