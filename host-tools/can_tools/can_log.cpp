#include "host-tools/can_tools/can_log.h"

#include <charconv>

namespace thimble::host {
namespace {

using firmware::link::CanFrame;

constexpr std::uint32_t kErrorFlag = 0x20000000;  // of an id in a log; CAN_ERR_FLAG
constexpr unsigned kBitRateSwitch = 0x1;          // of an FD frame's flags

template <class Number>
bool parse(std::string_view text, Number& value, int base) {
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value, base);
  return !text.empty() && error == std::errc{} && at == end;
}

// Up to the next blank; the rest stays.
std::string_view take_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r"), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(" \t\r"));
  text.remove_prefix(word.size());
  return word;
}

bool parse_data(std::string_view hex, CanFrame& frame) {
  const std::size_t most = frame.fd ? firmware::link::kFdDataBytes : firmware::link::kClassicDataBytes;
  if (hex.size() % 2 != 0 || hex.size() / 2 > most) return false;
  frame.size = static_cast<std::uint8_t>(hex.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i)
    if (!parse(hex.substr(2 * i, 2), frame.data[i], 16)) return false;
  return true;
}

bool parse_frame(std::string_view text, LoggedFrame& logged) {
  const std::size_t hash = text.find('#');
  if (hash != 3 && hash != 8) return false;
  CanFrame& frame = logged.frame;
  if (!parse(text.substr(0, hash), frame.id, 16)) return false;
  frame.extended = hash == 8;
  std::string_view data = text.substr(hash + 1);
  if (frame.extended && (frame.id & kErrorFlag) != 0) {
    logged.error = true;
    return true;
  }
  if (data.starts_with('#')) {
    unsigned flags = 0;
    if (data.size() < 2 || !parse(data.substr(1, 1), flags, 16)) return false;
    frame.fd = true;
    frame.bit_rate_switch = (flags & kBitRateSwitch) != 0;
    data.remove_prefix(2);
  } else if (data.starts_with('R')) {
    frame.remote = true;
    return is_valid(frame);
  }
  return parse_data(data, frame) && is_valid(frame);
}

}  // namespace

std::optional<LoggedFrame> parse_log_line(std::string_view line) {
  const std::string_view time = take_word(line);
  LoggedFrame logged;
  if (time.size() < 3 || time.front() != '(' || time.back() != ')') return std::nullopt;
  const std::string_view seconds = time.substr(1, time.size() - 2);
  const auto [at, error] = std::from_chars(seconds.data(), seconds.data() + seconds.size(), logged.time_s);
  if (error != std::errc{} || at != seconds.data() + seconds.size()) return std::nullopt;
  logged.interface = take_word(line);
  if (logged.interface.empty() || !parse_frame(take_word(line), logged)) return std::nullopt;
  return logged;
}

}  // namespace thimble::host
