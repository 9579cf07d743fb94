// The bytes of a request, for what is made of ServiceClient. Numbers are big-endian, as in UDS.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/link/proof.h"
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

[[nodiscard]] inline Bytes write_request(std::uint16_t did, std::uint32_t bits) {
  Bytes request = {byte_of(firmware::link::Service::kWriteData)};
  put_u16(request, did);
  for (unsigned shift = 0; shift < 32; shift += 8)
    request.push_back(static_cast<std::uint8_t>(bits >> shift));
  return request;
}

// Service 29.
[[nodiscard]] inline Bytes authentication_request(firmware::link::Authentication kind) {
  return {byte_of(firmware::link::Service::kAuthentication), static_cast<std::uint8_t>(kind)};
}
[[nodiscard]] inline Bytes challenge_request() {
  Bytes request = authentication_request(firmware::link::Authentication::kRequestChallenge);
  request.push_back(0);
  request.insert(request.end(), firmware::link::kAlgorithm.begin(), firmware::link::kAlgorithm.end());
  return request;
}
inline constexpr std::size_t kChallengeAt = 3 + firmware::link::kAlgorithm.size() + 2;  // in the answer
[[nodiscard]] inline Bytes proof_request(const firmware::link::Proof& proof) {
  Bytes request = authentication_request(firmware::link::Authentication::kVerifyProof);
  request.insert(request.end(), firmware::link::kAlgorithm.begin(), firmware::link::kAlgorithm.end());
  put_u16(request, static_cast<std::uint32_t>(proof.size()));
  request.insert(request.end(), proof.begin(), proof.end());
  put_u32(request, 0);  // neither a challenge of this host nor an additional parameter
  return request;
}

}  // namespace thimble::host
