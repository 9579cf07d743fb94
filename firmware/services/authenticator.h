// Who may command where the board has a key (store/key_store.h): a host that has proven that it has it, by service 29. Background context.
//
// A host asks for a challenge, and answers it with a proof (firmware/link/proof.h). A challenge is for one host and one proof; until then
// it is given again, because answers are lost and repeated on the way. After a wrong proof the host gets no challenge for kFirstDelay_us,
// after the next one for twice as long, and so on up to kLongestDelay_us. The delay is the host's own: with one for all, a host without the
// key would keep its owner out. That a host can leave and come back as a new one does not help it: a key has 256 bits. The proof counts
// until the place of the host ends, or the key is another one.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/services/call.h"
#include "firmware/store/key_store.h"

namespace thimble::firmware {

class Authenticator {
 public:
  static constexpr link::Micros kFirstDelay_us = 500'000;
  static constexpr link::Micros kLongestDelay_us = 16'000'000;

  Authenticator(KeyStore& keys, std::uint8_t node) noexcept : keys_(keys), node_(node) {}
  // Before the first request. A number that no start before had.
  void begin(std::uint32_t start) noexcept { start_ = start; }

  [[nodiscard]] bool allows(const Host& host) const noexcept {
    return keys_.state() == link::KeyState::kNone ||
           (keys_.state() == link::KeyState::kSet && host.key == keys_.number());
  }
  // kOk, and the challenge; kConditionsNotCorrect: there is no key to prove; kRequiredTimeDelayNotExpired.
  [[nodiscard]] Nrc challenge(Host& host, link::Micros now, link::Challenge& challenge) noexcept;
  // kOk: the host has the key. kRequestSequenceError: it has no challenge; kOwnershipVerificationFailed: the proof is wrong.
  [[nodiscard]] Nrc prove(Host& host, link::Micros now, std::span<const std::uint8_t> proof) noexcept;

 private:
  KeyStore& keys_;
  std::uint8_t node_;
  std::uint32_t start_ = 0;
  std::uint32_t challenges_ = 0;  // so many were given
};

}  // namespace thimble::firmware
