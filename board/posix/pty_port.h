// SLCAN on a pseudo-terminal, which a host opens like a serial port.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "board/posix/port.h"
#include "board/posix/slcan_stream.h"

namespace thimble::board {

class PtyPort final : public Port {
 public:
  // `link`: path of a symbolic link to the pty, or empty. Throws std::runtime_error with the cause.
  explicit PtyPort(const std::string& link);
  PtyPort(const PtyPort&) = delete;
  PtyPort& operator=(const PtyPort&) = delete;
  ~PtyPort() override;

  [[nodiscard]] std::vector<std::string> uris() const override { return {uri_}; }
  void add_to(std::vector<pollfd>& polled) const override { polled.push_back(stream_->polled()); }
  void read() override { stream_->read(); }
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override { return stream_->receive(); }
  void send(const firmware::link::CanFrame& frame) override { stream_->send(frame); }
  void flush() override { stream_->flush(); }
  [[nodiscard]] bool waiting() const override { return stream_->waiting(); }
  [[nodiscard]] std::uint64_t dropped() const override { return stream_->dropped(); }

 private:
  std::optional<SlcanStream> stream_;
  Descriptor slave_;  // kept open: otherwise the pty would close with its first client
  std::string link_;
  std::string uri_;
};

}  // namespace thimble::board
