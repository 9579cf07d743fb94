#include "firmware/link/can_frame.h"

#include <algorithm>

namespace thimble::firmware::link {
namespace {

constexpr std::array<std::uint8_t, 16> kSizes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

}  // namespace

bool operator==(const CanFrame& a, const CanFrame& b) noexcept {
  return a.id == b.id && a.extended == b.extended && a.remote == b.remote && a.fd == b.fd &&
         a.bit_rate_switch == b.bit_rate_switch && a.size == b.size &&
         std::ranges::equal(a.bytes(), b.bytes());
}

bool is_valid(const CanFrame& frame) noexcept {
  if (frame.id > (frame.extended ? 0x1FFFFFFFU : 0x7FFU)) return false;
  if (frame.fd) return !frame.remote && frame.size <= kFdDataBytes && fd_size(frame.size) == frame.size;
  return !frame.bit_rate_switch && frame.size <= kClassicDataBytes;
}

std::uint8_t fd_size(std::size_t bytes) noexcept {
  const auto found = std::ranges::lower_bound(kSizes, bytes);
  return found == kSizes.end() ? kSizes.back() : *found;
}

std::uint8_t length_code(std::uint8_t size) noexcept {
  return static_cast<std::uint8_t>(std::ranges::lower_bound(kSizes, size) - kSizes.begin());
}

std::uint8_t size_of_length_code(std::uint8_t code) noexcept { return kSizes[code & 0x0FU]; }

}  // namespace thimble::firmware::link
