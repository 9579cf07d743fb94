// Addresses of hosts. Every host on a link has an address of its own, so that the controller tells hosts apart; it claims
// the address when it connects. The frames of a claim:
//
//   HostClaim  host to controller   29-bit id 0x1C<salt, 16 bits><node>   key (6 bytes, little-endian), action, 0
//   HostGrant  controller to hosts  29-bit id 0x1D0000<node>              key (6 bytes), address (0: refused), places
//
// The key is a random number that the host draws once for each connection; the controller answers each claim with its key, so
// all hosts may hear all grants. A claim may be repeated: the same key gets the same address while its place lasts. The salt
// is drawn for every claim frame. Two hosts that claim in the same bit time then have different identifiers, and CAN's
// arbitration lets one frame pass after the other; with equal identifiers and different data both would be destroyed.
//
// A tester that claims nothing uses kTesterAddress, as ISO 14229 testers do; there can be one of them.
// Both ends of the link use this header. Nothing here can fail but the decoders, which say so.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/link/can_frame.h"

namespace thimble::firmware::link {

inline constexpr std::size_t kMaxHosts = 4;  // that a controller serves at once
// Of the addresses of external test equipment, 0xF1 to 0xFD (ISO 14229-3), those that are granted. They are more than
// kMaxHosts: an address that became free is granted again as late as possible.
inline constexpr std::uint8_t kFirstHostAddress = 0xF2;
inline constexpr std::uint8_t kLastHostAddress = 0xFD;
// A host's place ends so long after the last frame that the controller had from it: S3 of ISO 14229.
inline constexpr Micros kHostTimeout_us = 5'000'000;

inline constexpr std::uint64_t kHostKeyMask = 0xFFFF'FFFF'FFFF;  // 48 bits; 0 is no key

enum class ClaimAction : std::uint8_t { kClaim = 1, kRelease = 2 };

struct HostClaim {
  std::uint64_t key = 0;
  ClaimAction action = ClaimAction::kClaim;
};

struct HostGrant {
  std::uint64_t key = 0;
  std::uint8_t address = 0;  // 0: all places are taken
  std::uint8_t places = kMaxHosts;
};

// The identifiers of all claims to a node: those whose bits under kClaimMask are claim_id(node).
inline constexpr std::uint32_t kClaimMask = 0x1F00'00FF;
[[nodiscard]] constexpr std::uint32_t claim_id(std::uint8_t node, std::uint16_t salt = 0) noexcept {
  return 0x1C00'0000U | static_cast<std::uint32_t>(salt) << 8U | node;
}
[[nodiscard]] constexpr std::uint32_t grant_id(std::uint8_t node) noexcept { return 0x1D00'0000U | node; }

[[nodiscard]] CanFrame to_frame(const HostClaim& claim, std::uint8_t node, std::uint16_t salt) noexcept;
[[nodiscard]] CanFrame to_frame(const HostGrant& grant, std::uint8_t node) noexcept;
// False: another frame, or one that is too short, has no key or an unknown action.
[[nodiscard]] bool from_frame(const CanFrame& frame, std::uint8_t node, HostClaim& claim) noexcept;
[[nodiscard]] bool from_frame(const CanFrame& frame, std::uint8_t node, HostGrant& grant) noexcept;

}  // namespace thimble::firmware::link
