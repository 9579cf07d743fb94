// The bytes of a request, for what is made of ServiceClient. Numbers are big-endian, as in UDS.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/link/services.h"

namespace thimble::host {

using Bytes = std::vector<std::uint8_t>;

[[nodiscard]] inline std::uint8_t byte_of(firmware::link::Service service) {
  return static_cast<std::uint8_t>(service);
}

inline void put_u16(Bytes& bytes, std::uint32_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

inline void put_u32(Bytes& bytes, std::uint32_t value) {
  put_u16(bytes, value >> 16U);
  put_u16(bytes, value);
}

inline constexpr std::uint8_t kStart = 0x01, kStop = 0x02, kResults = 0x03;  // of a routine

[[nodiscard]] inline Bytes routine_request(firmware::link::Routine routine, std::uint8_t action = kStart) {
  Bytes request = {byte_of(firmware::link::Service::kRoutine), action};
  put_u16(request, static_cast<std::uint16_t>(routine));
  return request;
}

[[nodiscard]] inline Bytes read_request(std::uint16_t did) {
  Bytes request = {byte_of(firmware::link::Service::kReadData)};
  put_u16(request, did);
  return request;
}

}  // namespace thimble::host
