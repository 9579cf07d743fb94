// One connection from a board to its hosts: a pty, a TCP port, a serial port or a CAN interface.
//
// Called by LinkPorts in the background context of the board; one thread. After construction no function
// blocks or throws: after a disconnected host, an unplugged cable or an interface that is down, the port
// continues when they are available again. Uses the heap.
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

  // Addresses for a host on this machine, the preferred one first; empty if the host's end has another name.
  [[nodiscard]] virtual std::vector<std::string> uris() const = 0;

  virtual void add_to(std::vector<pollfd>& polled) const = 0;  // file descriptors to wait for
  virtual void read() = 0;                                     // reads the available data
  // The next frame of the data that read() has read.
  [[nodiscard]] virtual std::optional<firmware::link::CanFrame> receive() = 0;
  // Sends to every host on this port, now or with a later flush(). Real-time frames (11-bit ids) that cannot
  // be sent soon are dropped.
  virtual void send(const firmware::link::CanFrame& frame) = 0;
  virtual void flush() = 0;
  [[nodiscard]] virtual bool waiting() const = 0;  // frames wait for flush(), possibly without a poll event
  [[nodiscard]] virtual std::uint64_t dropped() const = 0;  // frames
  // The bit rate of a classic CAN bus behind it, as it is set up now; 0: another kind of bus, or not known.
  [[nodiscard]] virtual std::uint32_t classic_bits_per_s() const { return 0; }
  // The present transmit problem, as a sentence without full stop; empty: none.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
};

}  // namespace thimble::board
