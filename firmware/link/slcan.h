// SLCAN: CAN frames as text lines on a byte stream (USB CDC, UART, pty, TCP), as slcand and python-can speak
// it; FD frames with CANable's d D b B.
//
//   tiiildd..\r  Tiiiiiiiildd..\r   data, 11- and 29-bit id      riiil\r  Riiiiiiiil\r   remote
//   d / D                           FD data                      b / B                   FD data with bit rate switch
//   O\r open   C\r close   Sn\r bit rate   V\r version   N\r serial   F\r status flags
//   \r: understood   BEL: refused
//
// Who calls it: both ends. Sans-I/O, no heap. A line that is malformed, cut off or too long is dropped whole
// and counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/link/can_frame.h"

namespace thimble::firmware::link {

// The longest line: type, 8 digits of id, length code, 64 bytes in hex, CR.
inline constexpr std::size_t kMaxSlcanLine = 1 + 8 + 1 + 2 * kFdDataBytes + 1;
using SlcanLine = std::array<char, kMaxSlcanLine>;

// The frame as a line with its CR; returns its length, or 0 for a frame that cannot stand on a bus.
[[nodiscard]] std::size_t encode_slcan(const CanFrame& frame, SlcanLine& line) noexcept;

class SlcanParser {
 public:
  enum class Event : std::uint8_t {
    kNone,     // give me more bytes
    kFrame,    // frame() is set
    kCommand,  // command() is set: O C S V N F ..., without arguments' meaning
    kAck,      // an empty line
    kRefused,  // BEL
    kBad,      // a line was dropped
  };

  // Takes one byte.
  [[nodiscard]] Event push(char byte) noexcept;

  [[nodiscard]] const CanFrame& frame() const noexcept { return frame_; }
  [[nodiscard]] std::span<const char> command() const noexcept { return {line_.data(), command_size_}; }
  [[nodiscard]] std::uint32_t bad_lines() const noexcept { return bad_lines_; }

 private:
  [[nodiscard]] Event finish() noexcept;

  SlcanLine line_{};
  std::size_t size_ = 0;
  std::size_t command_size_ = 0;
  bool too_long_ = false;
  std::uint32_t bad_lines_ = 0;
  CanFrame frame_;
};

}  // namespace thimble::firmware::link
