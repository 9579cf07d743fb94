// The argument of a service handler: a request, the host that sent it, and the answer to fill in. The router makes the Call and
// sends the answer; the handlers (handlers.h) do not deal with frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/link/byte_writer.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"

namespace thimble::firmware {

using link::Nrc;

// What the controller keeps of a host between its requests.
struct Host {
  std::uint8_t address = 0;  // on the link; 0: it has no place
  link::Session session = link::Session::kDefault;
  std::uint8_t wrong_proofs = 0;  // in a row (service 29)
  std::uint32_t key = 0;  // the number of the key that it has proven to have (KeyStore::number()); 0: none
  struct Challenge {
    std::uint32_t number = 0;   // 0: it has none
    link::Micros since_us = 0;  // when it was given, or the last proof came
  };
  Challenge challenge;                            // service 29
  std::optional<link::Reset> restart;             // wanted once the answer has left
  bool vanished = false;                          // it was silent until its place ended
  bool disarming = false;                         // it has asked for a disarm that no tick has obeyed yet
  std::uint32_t halts = 0;                        // Commands::halts() when its request came
  std::array<char, 192> refusal{};                // kDidRefusal: why its last request was refused, or empty
  std::array<char, link::kHostNameBytes> name{};  // kDidHostName; 0 behind its end
  link::Marked marked;                            // its last mark

  // Longer texts are cut.
  void refuse(const char* reason) noexcept;
};

struct Call {
  Host& host;
  std::span<const std::uint8_t> request;  // the service, then its arguments; at least 1 byte
  link::Micros now_us;
  link::ByteWriter& answer;   // begins with the service's positive response; sent if the handler says kOk
  bool suppressible = false;  // bit 80 of the sub-function means: no positive answer
  bool again = false;         // a request that is pending is handled once more
  bool sign_of_life = true;   // once answered positively, the host counts as alive

  // Byte 1 without its bit 80. Only for services that have a sub-function, and a request of at least 2 bytes.
  [[nodiscard]] std::uint8_t sub_function() noexcept {
    suppressible = true;
    return request[1] & static_cast<std::uint8_t>(~link::kSuppressPositive);
  }
};

[[nodiscard]] inline std::uint16_t u16_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}
[[nodiscard]] inline std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::uint32_t>(u16_at(bytes, at)) << 16U | u16_at(bytes, at + 2);
}

}  // namespace thimble::firmware
