// Frames as hexadecimal text, for tests.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "firmware/link/can_frame.h"

namespace thimble::test {

inline std::string hex_of(const firmware::link::CanFrame& frame) {
  std::string out;
  for (const std::uint8_t byte : frame.bytes()) {
    char text[3];
    std::snprintf(static_cast<char*>(text), sizeof(text), "%02x", unsigned{byte});
    out += static_cast<const char*>(text);
  }
  return out;
}

// Blanks are ignored.
inline firmware::link::CanFrame frame_of_hex(std::uint32_t id, std::string_view hex, bool fd = false) {
  firmware::link::CanFrame frame;
  frame.id = id;
  frame.extended = id > 0x7FF;
  frame.fd = frame.bit_rate_switch = fd;
  std::string digits;
  for (const char c : hex)
    if (c != ' ') digits += c;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    frame.data[frame.size++] = static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16));
  return frame;
}

}  // namespace thimble::test
