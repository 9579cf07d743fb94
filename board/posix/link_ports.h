// All ports of a board as one bus: what one host sends the board gets, what the board sends every host gets.
//
// Who calls it: thimble-sim's loop, and the background thread of a board on Linux. One thread. Nothing here blocks but wait().
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board/posix/port.h"
#include "firmware/link/can_frame.h"

namespace thimble::board {

class LinkPorts {
 public:
  void add(std::unique_ptr<Port> port) { ports_.push_back(std::move(port)); }
  [[nodiscard]] bool empty() const { return ports_.empty(); }

  [[nodiscard]] std::vector<std::string> uris() const;  // in the order in which the ports were added

  // Waits for something to read, at most so long (1 ms where something waits to be sent), and takes it in.
  void wait(std::uint64_t timeout_us);
  // The next frame that a host sent.
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);
  void flush();

  [[nodiscard]] std::uint64_t dropped() const;  // frames
  // What stands against sending on any port, for a log: each time it has changed since the last call.
  [[nodiscard]] std::optional<std::string> news();

 private:
  std::vector<std::unique_ptr<Port>> ports_;
  std::string trouble_;  // told
  std::vector<pollfd> polled_;
};

}  // namespace thimble::board
