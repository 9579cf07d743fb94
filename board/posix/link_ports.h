// All ports of a board as one bus: the board receives the frames of all hosts, and every host receives the
// frames of the board.
//
// Called by the loop of thimble-sim, and by the background thread of a board on Linux. One thread. Only
// wait() blocks.
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

  // Waits until data can be read, at most timeout_us (1 ms if frames wait to be sent), and reads them.
  void wait(std::uint64_t timeout_us);
  // The next frame received from a host.
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);
  void flush();

  [[nodiscard]] std::uint64_t dropped() const;  // frames
  // The bit rate of the slowest classic CAN bus (firmware::Config::bus_bits_per_s); 0: there is none, or it is not known.
  [[nodiscard]] std::uint32_t classic_bits_per_s() const;
  // Text for a log if the transmit problem of any port has changed since the last call.
  [[nodiscard]] std::optional<std::string> news();

 private:
  std::vector<std::unique_ptr<Port>> ports_;
  std::string trouble_;  // last reported by news()
  std::vector<pollfd> polled_;
};

}  // namespace thimble::board
