// A SocketCAN interface with any number of hosts on its bus, classic and FD frames. The system sets the bit
// rates of the interface and the restart after a bus-off (restart-ms), see docs/link.md.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "board/posix/descriptor.h"
#include "board/posix/port.h"

namespace thimble::board {

class CanPort final : public Port {
 public:
  // Receives frames for `node` and the e-stop frame. Throws std::runtime_error with a remedy if the interface
  // does not exist. The interface may be or go down, go bus-off, be stuck (no acknowledge) or be unplugged:
  // the port waits until it works again, and drops the frames to be sent in the meantime.
  CanPort(std::string interface, std::uint8_t node);

  [[nodiscard]] std::vector<std::string> uris() const override;
  void add_to(std::vector<pollfd>& polled) const override;
  void read() override;
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override;
  void send(const firmware::link::CanFrame& frame) override;
  void flush() override;
  [[nodiscard]] bool waiting() const override { return !real_time_.empty() || !services_.empty(); }
  [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }
  [[nodiscard]] std::uint32_t classic_bits_per_s() const override;
  [[nodiscard]] std::string trouble() const override;

 private:
  enum class State : std::uint8_t { kUp, kDown, kBusOff, kStuck, kGone };
  using Frames = std::deque<firmware::link::CanFrame>;

  void open_socket();  // throws
  void on_error_frame(std::uint32_t classes);
  void on_failure(int error);
  void drop_all();
  [[nodiscard]] bool write(const firmware::link::CanFrame& frame);

  std::string interface_;
  std::uint8_t node_;
  bool fd_frames_ = false;  // the interface supports them
  Descriptor socket_;
  State state_ = State::kUp;
  bool full_ = false;  // the kernel's queue is full: do not poll for space in the socket buffer
  std::chrono::steady_clock::time_point try_again_;
  // The last time at which a frame was sent or the queue was empty.
  std::chrono::steady_clock::time_point free_ = std::chrono::steady_clock::now();
  Frames received_;
  Frames real_time_;  // transmit queues; real_time_ first
  Frames services_;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::board
