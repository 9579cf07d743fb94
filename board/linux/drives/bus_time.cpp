#include "board/linux/drives/bus_time.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace thimble::board::drives {
namespace {

// FD with bit rate switch. Nominal: start of frame to BRS, then CRC delimiter to interframe space.
constexpr unsigned kNominalBits = 30;
constexpr unsigned kNominalStuffBits = 4;
constexpr unsigned kNominalBitsExtended = 49;
constexpr unsigned kNominalStuffBitsExtended = 8;
constexpr unsigned kEsiAndLength = 5;
constexpr unsigned kStuffCount = 4;
constexpr unsigned kLongestWithCrc17 = 16;

unsigned fd_data_bits(std::uint8_t size, Stuffing stuffing) {
  const unsigned free = kEsiAndLength + 8U * size;
  const unsigned stuffed = stuffing == Stuffing::kMost ? free / 4 : 0;
  const unsigned crc = size <= kLongestWithCrc17 ? 17 : 21;
  const unsigned fixed = (kStuffCount + crc) / 4 + 1;  // a fixed stuff bit before every four
  return free + stuffed + kStuffCount + crc + fixed;
}

struct Words {
  Exchange exchange;
  const char* one;
  const char* several;
};
constexpr std::array<Words, 8> kWords = {{
    {Exchange::kMoteusAll, "moteus with telemetry", "moteus with telemetry"},
    {Exchange::kMoteusMotion, "moteus", "moteus"},
    {Exchange::kOdriveCyclic, "ODrive", "ODrives"},
    {Exchange::kOdriveDamped, "damped ODrive", "damped ODrives"},
    {Exchange::kOdriveRequested, "requested ODrive", "requested ODrives"},
    {Exchange::kMiniCheetah, "mini-cheetah drive", "mini-cheetah drives"},
    {Exchange::kEightBytes, "classic MIT-mode drive", "classic MIT-mode drives"},
    {Exchange::kEightBytesFd, "Damiao FD drive", "Damiao FD drives"},
}};
constexpr std::array<const char*, 8> kNumbers = {"no", "one", "two", "three", "four", "five", "six", "seven"};

// Appends, and says how long the text is then.
class Text {
 public:
  explicit Text(std::span<char> out) : out_(out) { out_[0] = '\0'; }
  template <class... Values>
  void add(const char* format, Values... values) {
    const int wrote = std::snprintf(out_.data() + used_, out_.size() - used_, format, values...);
    if (wrote > 0) used_ = std::min(used_ + static_cast<std::size_t>(wrote), out_.size() - 1);
  }

 private:
  std::span<char> out_;
  std::size_t used_ = 0;
};

void add_drives(Text& text, std::span<const Exchange> drives) {
  const char* comma = "";
  for (const Words& words : kWords) {
    const auto count = static_cast<std::size_t>(std::ranges::count(drives, words.exchange));
    if (count == 0) continue;
    if (count < kNumbers.size()) {
      text.add("%s%s %s", comma, kNumbers[count], count == 1 ? words.one : words.several);
    } else {
      text.add("%s%zu %s", comma, count, words.several);
    }
    comma = " and ";
  }
}

}  // namespace

float frame_time_us(std::uint8_t size, bool fd, bool extended, const BusRate& rate,
                    Stuffing stuffing) noexcept {
  const bool most = stuffing == Stuffing::kMost;
  if (!fd) {
    const unsigned bits = most ? 55U + 10U * size : 47U + 8U * size;
    return static_cast<float>(bits) / rate.nominal_bits_s * 1e6F;
  }
  unsigned nominal = extended ? kNominalBitsExtended : kNominalBits;
  if (most) nominal += extended ? kNominalStuffBitsExtended : kNominalStuffBits;
  return (static_cast<float>(nominal) / rate.nominal_bits_s +
          static_cast<float>(fd_data_bits(size, stuffing)) / rate.data_bits_s) *
         1e6F;
}

float exchange_time_us(Exchange exchange, Stuffing stuffing, const BusRate& rate) noexcept {
  const auto classic = [&](std::uint8_t size) { return frame_time_us(size, false, false, rate, stuffing); };
  const auto fd = [&](std::uint8_t size, bool extended) {
    return frame_time_us(size, true, extended, rate, stuffing);
  };
  switch (exchange) {
    case Exchange::kMoteusAll:
      return fd(32, true) + fd(32, false);
    case Exchange::kMoteusMotion:
      return fd(24, true) + fd(12, false);
    case Exchange::kOdriveCyclic:
      return classic(4) + classic(8);
    case Exchange::kOdriveRequested:
      return classic(8) + classic(0) + classic(8);
    case Exchange::kMiniCheetah:
      return classic(8) + classic(7);
    case Exchange::kOdriveDamped:
    case Exchange::kEightBytes:
      return 2 * classic(8);
    case Exchange::kEightBytesFd:
      return 2 * fd(8, false);
  }
  return 0;
}

BusLoad bus_load(std::string_view interface, std::span<const Exchange> drives, float rate_Hz,
                 const BusRate& rate) noexcept {
  BusLoad load;
  for (const Exchange exchange : drives) load.time_us += exchange_time_us(exchange, Stuffing::kMost, rate);
  load.share = load.time_us * 1e-6F * rate_Hz;
  load.fits = load.share <= kMostLoad;
  Text text(load.text);
  add_drives(text, drives);
  // Rounded up: 81.0 % does not fit, and must not read as 80 %.
  const int percent = static_cast<int>(std::ceil(load.share * 100 - 1e-3F));
  text.add(" at %g kHz need%s %d %% of %.*s", static_cast<double>(rate_Hz) / 1000,
           drives.size() == 1 ? "s" : "", percent, static_cast<int>(interface.size()), interface.data());
  if (!load.fits)
    text.add(", of which %d %% may be used: move drives to another bus, or lower the rate",
             static_cast<int>(std::lround(kMostLoad * 100)));
  return load;
}

}  // namespace thimble::board::drives
