// The board's end of an SLCAN connection to one host over a byte stream. Telemetry that the host does not
// read in time is dropped. Used by the pty, TCP and serial ports.
#pragma once

#include <poll.h>

#include <chrono>
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
  // Non-blocking. A socket is closed at a blank: SLCAN has none, and an HTTP request has one in its first line. Any web page can send one
  // to a port of this machine, with SLCAN in its body.
  // The channel of kStopsOnly stays closed: the e-stop frame is taken, and nothing else; nothing is sent there.
  enum class Kind : std::uint8_t { kTerminal, kSocket, kStopsOnly };
  explicit SlcanStream(Descriptor fd, Kind kind = Kind::kTerminal) : fd_(std::move(fd)), kind_(kind) {}

  [[nodiscard]] pollfd polled() const;
  void read();
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);  // ignored until the host has opened the channel
  void flush();

  [[nodiscard]] bool waiting() const { return !out_.empty(); }
  // The host has closed the connection, or it has to be closed.
  [[nodiscard]] bool gone() const { return gone_; }
  // When bytes came last.
  [[nodiscard]] std::chrono::steady_clock::time_point heard() const { return heard_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  void drop();

  Descriptor fd_;
  Kind kind_;
  std::chrono::steady_clock::time_point heard_ = std::chrono::steady_clock::now();
  bool gone_ = false;
  firmware::link::SlcanPort port_;
  std::string in_;
  std::size_t in_at_ = 0;
  std::string out_;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::board
