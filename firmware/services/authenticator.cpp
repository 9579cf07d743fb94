// Service 29 (authentication), and routine 020B (the key).
#include "firmware/services/authenticator.h"

#include <algorithm>
#include <tuple>

#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {

using link::Authentication;
using link::KeyState;

Nrc Authenticator::challenge(Host& host, link::Micros now, link::Challenge& challenge) noexcept {
  if (keys_.state() != KeyState::kSet) {
    host.refuse(keys_.state() == KeyState::kNone ? "no_key" : "key_damaged");
    return Nrc::kConditionsNotCorrect;
  }
  Host::Challenge& last = host.challenge;
  if (last.number == 0) {
    const link::Micros delay_us =
        std::min(kFirstDelay_us << std::min(unsigned{host.wrong_proofs}, 8U) >> 1U, kLongestDelay_us);
    if (host.wrong_proofs != 0 && now - last.since_us < delay_us) return Nrc::kRequiredTimeDelayNotExpired;
    last = {++challenges_, now};
  }
  challenge = link::challenge_of(keys_.key(), start_, last.number, last.since_us);
  return Nrc::kOk;
}

Nrc Authenticator::prove(Host& host, link::Micros now, std::span<const std::uint8_t> proof) noexcept {
  const Host::Challenge given = host.challenge;
  if (given.number == 0 || keys_.state() != KeyState::kSet) return Nrc::kRequestSequenceError;
  const link::Challenge challenge = link::challenge_of(keys_.key(), start_, given.number, given.since_us);
  host.challenge = {0, now};
  if (link::same(link::proof_of(keys_.key(), node_, host.address, challenge), proof)) {
    host.key = keys_.number();
    host.wrong_proofs = 0;
    return Nrc::kOk;
  }
  host.wrong_proofs = static_cast<std::uint8_t>(std::min(host.wrong_proofs + 1, 255));
  return Nrc::kOwnershipVerificationFailed;
}

namespace {

// 29 05 communication configuration(1) algorithm(16)
Nrc request_challenge(Services& services, Call& call) noexcept {
  constexpr std::size_t kBytes = 3 + link::kAlgorithm.size();
  if (call.request.size() != kBytes) return Nrc::kIncorrectLength;
  if (!std::ranges::equal(call.request.subspan(3), link::kAlgorithm)) return Nrc::kRequestOutOfRange;
  link::Challenge challenge;
  const Nrc result = services.authenticator.challenge(call.host, call.now_us, challenge);
  if (result != Nrc::kOk) return result;
  call.answer.put(link::kRequestAccepted);
  call.answer.put(link::kAlgorithm);
  call.answer.put_u16(static_cast<std::uint16_t>(challenge.size()));
  call.answer.put(challenge);
  call.answer.put_u16(0);  // no additional parameter is needed
  return Nrc::kOk;
}

// 29 06 algorithm(16) length(2) proof, length(2) challenge of the host, length(2) additional parameter: the last two are empty
Nrc verify_proof(Services& services, Call& call) noexcept {
  constexpr std::size_t kLength = 2 + link::kAlgorithm.size(), kProof = kLength + 2,
                        kBytes = kProof + std::tuple_size_v<link::Proof> + 4;
  if (call.request.size() != kBytes) return Nrc::kIncorrectLength;
  const bool ours = std::ranges::equal(call.request.subspan(2, link::kAlgorithm.size()), link::kAlgorithm);
  if (!ours || u16_at(call.request, kLength) != std::tuple_size_v<link::Proof> ||
      u32_at(call.request, kBytes - 4) != 0)
    return Nrc::kRequestOutOfRange;
  const Nrc result = services.authenticator.prove(
      call.host, call.now_us, call.request.subspan(kProof, std::tuple_size_v<link::Proof>));
  if (result == Nrc::kOwnershipVerificationFailed)
    services.parts.audit.add(link::AuditEvent::kProofRefused, call.host, call.now_us);
  if (result != Nrc::kOk) return result;
  call.answer.put(link::kOwnershipVerified);
  call.answer.put(link::kAlgorithm);
  call.answer.put_u16(0);  // no session key
  return Nrc::kOk;
}

}  // namespace

Nrc authentication(Services& services, Call& call) noexcept {
  if (call.request.size() < 2) return Nrc::kIncorrectLength;
  const std::uint8_t kind = call.sub_function();
  call.answer.put(kind);
  if (kind == static_cast<std::uint8_t>(Authentication::kRequestChallenge))
    return request_challenge(services, call);
  if (kind == static_cast<std::uint8_t>(Authentication::kVerifyProof)) return verify_proof(services, call);
  return Nrc::kSubFunctionNotSupported;
}

// Whoever sets the key has it.
Nrc set_key(Services& services, Call& call) noexcept {
  call.host.refuse("");
  if (!motors_off(services.parts.core)) return refuse(call.host, kWrongMode, "");
  link::Key key;
  std::ranges::copy(routine_arguments(call), key.begin());
  const Nrc result = refuse(call.host, services.parts.keys.set(key));
  if (result != Nrc::kOk) return result;
  call.host.key = services.parts.keys.number();
  services.parts.audit.add(link::AuditEvent::kKeySet, call.host, call.now_us);
  return result;
}

Nrc remove_key(Services& services, Call& call) noexcept {
  call.host.refuse("");
  if (!motors_off(services.parts.core)) return refuse(call.host, kWrongMode, "");
  const Nrc result = refuse(call.host, services.parts.keys.remove());
  if (result == Nrc::kOk) services.parts.audit.add(link::AuditEvent::kKeyRemoved, call.host, call.now_us);
  return result;
}

}  // namespace thimble::firmware
