// SLCAN on one end of a connected pair of sockets: the link to a host in the same process, which keeps the other end open as long as the
// board runs. No other process can connect to it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board/posix/port.h"
#include "board/posix/slcan_stream.h"

namespace thimble::board {

class PairPort final : public Port {
 public:
  explicit PairPort(Descriptor end) : stream_(std::move(end), SlcanStream::Kind::kSocket) {}

  [[nodiscard]] std::vector<std::string> uris() const override { return {}; }
  void add_to(std::vector<pollfd>& polled) const override { polled.push_back(stream_.polled()); }
  void read() override { stream_.read(); }
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override { return stream_.receive(); }
  void send(const firmware::link::CanFrame& frame) override { stream_.send(frame); }
  void flush() override { stream_.flush(); }
  [[nodiscard]] bool waiting() const override { return stream_.waiting(); }
  [[nodiscard]] std::uint64_t dropped() const override { return stream_.dropped(); }

 private:
  SlcanStream stream_;
};

}  // namespace thimble::board
