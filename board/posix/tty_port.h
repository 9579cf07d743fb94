// SLCAN on an existing serial port: the device end of USB (/dev/ttyGS0) or a UART. The host's end of the
// cable has another name.
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
  // Throws std::runtime_error with a remedy if the serial port cannot be opened now. If it disappears later
  // (the cable is unplugged, the gadget is removed), it is opened again when it is back.
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
  [[nodiscard]] bool open_tty();  // false: see errno

  std::string path_;
  std::optional<SlcanStream> stream_;
  std::chrono::steady_clock::time_point try_again_;
  std::uint64_t dropped_ = 0;  // of earlier connections
};

}  // namespace thimble::board
