// The board's end of an SLCAN connection to one host over a byte stream. Telemetry that the host does not
// read in time is dropped. Used by the pty, TCP and serial ports.
#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "board/posix/descriptor.h"
#include "firmware/link/can_frame.h"
#include "firmware/link/slcan_port.h"

namespace thimble::board {

class SlcanStream {
 public:
  explicit SlcanStream(Descriptor fd) : fd_(std::move(fd)) {}  // non-blocking

  [[nodiscard]] pollfd polled() const;
  void read();
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);  // ignored until the host has opened the channel
  void flush();

  [[nodiscard]] bool waiting() const { return !out_.empty(); }
  [[nodiscard]] bool gone() const { return gone_; }  // the host has closed the connection
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  Descriptor fd_;
  bool gone_ = false;
  firmware::link::SlcanPort port_;
  std::string in_;
  std::size_t in_at_ = 0;
  std::string out_;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::board
