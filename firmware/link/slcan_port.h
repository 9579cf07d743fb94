// The device's end of a byte stream that speaks SLCAN: frames out of it, and the commands of slcand, python-can and
// `thimble` answered. Sans-I/O, no heap; one context.
//
//   switch (port.push(byte)) { case kFrame: controller.on_frame(port.frame(), now); ... }
//   send(port.reply());                                    // after every push, before what else is to be sent
//   if (port.open()) send(line of encode_slcan(frame));    // frames only while the channel is open; an e-stop frame is heard always
#pragma once

#include <string_view>

#include "firmware/link/slcan.h"

namespace thimble::firmware::link {

class SlcanPort {
 public:
  enum class Event : std::uint8_t {
    kNone,
    kFrame,   // frame() is set
    kClosed,  // the host closed the channel: what waits to be sent was for it
  };
  [[nodiscard]] Event push(char byte) noexcept;

  [[nodiscard]] const CanFrame& frame() const noexcept { return parser_.frame(); }
  // What the last byte is answered with; empty mostly.
  [[nodiscard]] std::string_view reply() const noexcept { return reply_; }
  [[nodiscard]] bool open() const noexcept { return open_; }
  void close() noexcept { open_ = false; }  // the host takes nothing: until it opens the channel again

 private:
  SlcanParser parser_;
  std::string_view reply_;
  bool open_ = false;
};

}  // namespace thimble::firmware::link
