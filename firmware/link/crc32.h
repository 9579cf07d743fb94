// CRC-32 of IEEE 802.3 (zlib's crc32): of a scene image when it is announced, of a slot's header and contents, of a
// recording's forces. Both ends of the link compute it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::firmware::link {

inline constexpr std::array<std::uint32_t, 256> kCrc32Table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
    table[i] = value;
  }
  return table;
}();

// To continue, pass the last result as `crc`.
[[nodiscard]] inline std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t crc = 0) noexcept {
  crc = ~crc;
  for (const std::byte byte : bytes)
    crc = (crc >> 8U) ^ kCrc32Table[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xFFU];
  return ~crc;
}

}  // namespace thimble::firmware::link
