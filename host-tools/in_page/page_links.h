// Carriers of frames in a page: to the board in this module, and as SLCAN to a serial port.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "board/sim/live_loop.h"
#include "firmware/link/slcan.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

// Frames between the board and the session of this module.
class InnerLink final : public board::LiveLoop::Carrier {
 public:
  void send(const link::CanFrame& frame) override { to_host_.push_back(frame); }
  [[nodiscard]] std::optional<link::CanFrame> receive() override;
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

  [[nodiscard]] std::unique_ptr<Transport> connect();
  [[nodiscard]] bool has_news() const { return !to_host_.empty(); }

 private:
  class End;
  std::deque<link::CanFrame> to_host_, to_board_;
};

// A serial port that the page has opened.
class SerialLink {
 public:
  [[nodiscard]] std::unique_ptr<Transport> connect();  // Error kLinkLost: the port is closed

  void take(std::string_view bytes);  // from the port
  [[nodiscard]] bool has_news() const { return !frames_.empty() || !open_; }
  [[nodiscard]] std::string give() { return std::exchange(out_, {}); }  // for the port
  void set_open(bool open);

 private:
  class End;
  void throw_if_closed() const;
  link::SlcanParser parser_;
  std::deque<link::CanFrame> frames_;
  std::string out_;
  bool open_ = false;
};

// Waits until there may be news, at most `time_us`. Whoever calls it must not be in a handler of an exception (see device.cpp).
void wait_for_page(link::Micros time_us);

}  // namespace thimble::host
