// SLCAN on a serial port that exists: the device end of USB (/dev/ttyGS0), a UART. The host's end of the cable has a name of its own.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "board/posix/port.h"
#include "board/posix/slcan_stream.h"

namespace thimble::board {

class TtyPort final : public Port {
 public:
  // Throws std::runtime_error with what to do when it cannot be opened now. Later it may go (the cable is pulled, the gadget is taken
  // away): the port opens it again when it is back.
  explicit TtyPort(std::string path);

  [[nodiscard]] std::vector<std::string> uris() const override { return {}; }
  void add_to(std::vector<pollfd>& polled) const override;
  void read() override;
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override;
  void send(const firmware::link::CanFrame& frame) override;
  void flush() override;
  [[nodiscard]] bool waiting() const override { return stream_ && stream_->waiting(); }
  [[nodiscard]] std::uint64_t dropped() const override;
  [[nodiscard]] std::string trouble() const override;

 private:
  [[nodiscard]] bool open_tty();  // false: errno says why

  std::string path_;
  std::optional<SlcanStream> stream_;
  std::chrono::steady_clock::time_point try_again_;
  std::uint64_t dropped_ = 0;  // of the times before
};

}  // namespace thimble::board
