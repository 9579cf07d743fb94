#include "firmware/link/slcan.h"

namespace thimble::firmware::link {
namespace {

constexpr char kCarriageReturn = '\r';
constexpr char kBell = '\a';

[[nodiscard]] char to_hex(std::uint32_t nibble) noexcept { return "0123456789ABCDEF"[nibble & 0xFU]; }

// 0..15, or -1.
[[nodiscard]] int from_hex(char digit) noexcept {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  return -1;
}

[[nodiscard]] bool parse_hex(std::span<const char> digits, std::uint32_t& value) noexcept {
  value = 0;
  for (const char digit : digits) {
    const int nibble = from_hex(digit);
    if (nibble < 0) return false;
    value = value << 4U | static_cast<std::uint32_t>(nibble);
  }
  return true;
}

// The letter of a frame, lower case for 11-bit ids except that FD has b/B beside d/D.
[[nodiscard]] char letter(const CanFrame& frame) noexcept {
  const char small = frame.fd ? (frame.bit_rate_switch ? 'b' : 'd') : (frame.remote ? 'r' : 't');
  return frame.extended ? static_cast<char>(small - 'a' + 'A') : small;
}

[[nodiscard]] bool is_frame_letter(char c) noexcept {
  return c == 't' || c == 'T' || c == 'r' || c == 'R' || c == 'd' || c == 'D' || c == 'b' || c == 'B';
}

[[nodiscard]] bool parse_frame(std::span<const char> line, CanFrame& frame) noexcept {
  CanFrame read;
  const char type = line[0];
  read.extended = type >= 'A' && type <= 'Z';
  const char small = read.extended ? static_cast<char>(type - 'A' + 'a') : type;
  read.fd = small == 'd' || small == 'b';
  read.bit_rate_switch = small == 'b';
  read.remote = small == 'r';

  const std::size_t id_digits = read.extended ? 8 : 3;
  if (line.size() < 1 + id_digits + 1) return false;
  if (!parse_hex(line.subspan(1, id_digits), read.id)) return false;
  const int code = from_hex(line[1 + id_digits]);
  if (code < 0 || (!read.fd && code > 8)) return false;
  read.size = size_of_length_code(static_cast<std::uint8_t>(code));

  const std::span<const char> digits = line.subspan(1 + id_digits + 1);
  if (digits.size() != (read.remote ? 0U : 2U * read.size)) return false;
  for (std::size_t i = 0; i < digits.size(); i += 2) {
    std::uint32_t byte = 0;
    if (!parse_hex(digits.subspan(i, 2), byte)) return false;
    read.data[i / 2] = static_cast<std::uint8_t>(byte);
  }
  if (!is_valid(read)) return false;
  frame = read;
  return true;
}

}  // namespace

std::size_t encode_slcan(const CanFrame& frame, SlcanLine& line) noexcept {
  if (!is_valid(frame)) return 0;
  std::size_t size = 0;
  line[size++] = letter(frame);
  for (unsigned digit = frame.extended ? 8 : 3; digit-- > 0;) line[size++] = to_hex(frame.id >> (4U * digit));
  line[size++] = to_hex(length_code(frame.size));
  if (!frame.remote) {
    for (const std::uint8_t byte : frame.bytes()) {
      line[size++] = to_hex(byte >> 4U);
      line[size++] = to_hex(byte);
    }
  }
  line[size++] = kCarriageReturn;
  return size;
}

SlcanParser::Event SlcanParser::push(char byte) noexcept {
  if (byte == '\n') return Event::kNone;  // terminals send CR LF
  if (byte == kBell && size_ == 0 && !too_long_) return Event::kRefused;
  if (byte == kCarriageReturn || byte == kBell) return finish();
  if (size_ == line_.size()) {
    too_long_ = true;
  } else {
    line_[size_++] = byte;
  }
  return Event::kNone;
}

SlcanParser::Event SlcanParser::finish() noexcept {
  const std::span<const char> line(line_.data(), size_);
  const bool too_long = too_long_;
  size_ = 0;
  too_long_ = false;
  if (line.empty()) return Event::kAck;
  if (!too_long && is_frame_letter(line[0]) && parse_frame(line, frame_)) return Event::kFrame;
  if (!too_long && !is_frame_letter(line[0])) {
    command_size_ = line.size();
    return Event::kCommand;
  }
  ++bad_lines_;
  return Event::kBad;
}

}  // namespace thimble::firmware::link
