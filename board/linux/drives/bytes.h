// Little-endian fields of a frame. Offsets are bytes from 0. The caller keeps them inside the frame's 64 bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/link/can_frame.h"

namespace thimble::board::drives {

inline void put_u(firmware::link::CanFrame& frame, std::size_t offset, std::uint32_t value,
                  std::size_t bytes) noexcept {
  for (std::size_t i = 0; i < bytes; ++i)
    frame.data[offset + i] = static_cast<std::uint8_t>(value >> (8U * i));
}

inline void put_float(firmware::link::CanFrame& frame, std::size_t offset, float value) noexcept {
  put_u(frame, offset, std::bit_cast<std::uint32_t>(value), 4);
}

[[nodiscard]] inline std::uint32_t get_u(const firmware::link::CanFrame& frame, std::size_t offset,
                                         std::size_t bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i)
    value |= static_cast<std::uint32_t>(frame.data[offset + i]) << (8U * i);
  return value;
}

[[nodiscard]] inline float get_float(const firmware::link::CanFrame& frame, std::size_t offset) noexcept {
  return std::bit_cast<float>(get_u(frame, offset, 4));
}

}  // namespace thimble::board::drives
