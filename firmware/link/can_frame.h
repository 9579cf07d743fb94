// One CAN frame, classic or FD, and the ids that Thimble uses. The one wire format: SocketCAN carries it as
// it is, a byte stream carries it as SLCAN text (slcan.h).
//
// Who calls it: everyone on either end of the link. Plain data; nothing here fails.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::firmware::link {

// Microseconds of a monotonic clock that the caller chooses: the link never reads a clock itself.
using Micros = std::uint64_t;

inline constexpr std::size_t kClassicDataBytes = 8;
inline constexpr std::size_t kFdDataBytes = 64;

struct CanFrame {
  std::uint32_t id = 0;   // 11 bits, or 29 when extended
  bool extended = false;  // 29-bit id
  bool remote = false;    // classic only; carries no data
  bool fd = false;
  bool bit_rate_switch = false;  // FD only
  std::uint8_t size = 0;         // bytes of data: 0..8, and for FD also 12, 16, 20, 24, 32, 48, 64
  std::array<std::uint8_t, kFdDataBytes> data{};

  [[nodiscard]] std::span<const std::uint8_t> bytes() const noexcept { return {data.data(), size}; }
};

[[nodiscard]] bool operator==(const CanFrame& a, const CanFrame& b) noexcept;

// True when the id, the size and the flags can stand on a bus.
[[nodiscard]] bool is_valid(const CanFrame& frame) noexcept;

// The smallest size that an FD frame can have for `bytes` of data (0..64).
[[nodiscard]] std::uint8_t fd_size(std::size_t bytes) noexcept;

// The length code (0..15) of a valid size, and back.
[[nodiscard]] std::uint8_t length_code(std::uint8_t size) noexcept;
[[nodiscard]] std::uint8_t size_of_length_code(std::uint8_t code) noexcept;

// 29-bit ids of the services (ISO 15765-2 normal fixed addressing): a host asks, the node answers. Each host has an address of
// its own (host_address.h); kTesterAddress is that of a tester that claims none.
inline constexpr std::uint8_t kTesterAddress = 0xF1;
[[nodiscard]] constexpr std::uint32_t request_id(std::uint8_t node,
                                                 std::uint8_t host = kTesterAddress) noexcept {
  return 0x18DA0000U | static_cast<std::uint32_t>(node) << 8U | host;
}
[[nodiscard]] constexpr std::uint32_t response_id(std::uint8_t node,
                                                  std::uint8_t host = kTesterAddress) noexcept {
  return 0x18DA0000U | static_cast<std::uint32_t>(host) << 8U | node;
}
// The requests of all hosts to a node are those whose bits under this mask are request_id(node)'s.
inline constexpr std::uint32_t kRequestMask = 0x1FFFFFF0;
static_assert((request_id(0, 0xF0) & kRequestMask) == (request_id(0, 0xFF) & kRequestMask));

}  // namespace thimble::firmware::link
