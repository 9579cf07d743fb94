// A SocketCAN interface: any number of hosts on its bus, classic and FD frames. The interface's bit rates, and the restart after a
// bus-off (restart-ms), are the system's to set (docs/link.md).
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
  // Takes in what is meant for `node`, and the e-stop. Throws std::runtime_error with what to do when there is no such interface. It
  // may be down, go down, leave the bus, be stuck (nobody acknowledges) or be unplugged: the port waits until it is back, and drops
  // what it was to send meanwhile.
  CanPort(std::string interface, std::uint8_t node);

  [[nodiscard]] std::vector<std::string> uris() const override;
  void add_to(std::vector<pollfd>& polled) const override;
  void read() override;
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override;
  void send(const firmware::link::CanFrame& frame) override;
  void flush() override;
  [[nodiscard]] bool waiting() const override { return !real_time_.empty() || !services_.empty(); }
  [[nodiscard]] std::uint64_t dropped() const override { return dropped_; }
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
  bool fd_frames_ = false;  // the interface carries them
  Descriptor socket_;
  State state_ = State::kUp;
  bool full_ = false;  // the kernel's queue: no use to wake up for room in the socket's
  std::chrono::steady_clock::time_point try_again_;
  // When a frame left, or none waited, last.
  std::chrono::steady_clock::time_point free_ = std::chrono::steady_clock::now();
  Frames received_;
  Frames real_time_;  // both to be sent, this one first
  Frames services_;
  std::uint64_t dropped_ = 0;
};

}  // namespace thimble::board
