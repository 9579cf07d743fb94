#include "firmware/link/host_address.h"

namespace thimble::firmware::link {
namespace {

constexpr std::size_t kKeyBytes = 6;

CanFrame make_frame(std::uint32_t id, std::uint64_t key, std::uint8_t sixth, std::uint8_t seventh) noexcept {
  CanFrame frame;
  frame.id = id;
  frame.extended = true;
  frame.size = kClassicDataBytes;
  for (std::size_t i = 0; i < kKeyBytes; ++i) frame.data[i] = static_cast<std::uint8_t>(key >> (8 * i));
  frame.data[kKeyBytes] = sixth;
  frame.data[kKeyBytes + 1] = seventh;
  return frame;
}

std::uint64_t key_of(const CanFrame& frame) noexcept {
  std::uint64_t key = 0;
  for (std::size_t i = 0; i < kKeyBytes; ++i) key |= static_cast<std::uint64_t>(frame.data[i]) << (8 * i);
  return key;
}

bool is_data_of(const CanFrame& frame, std::uint32_t id, std::uint32_t mask) noexcept {
  return frame.extended && !frame.remote && (frame.id & mask) == id && frame.size >= kClassicDataBytes;
}

}  // namespace

CanFrame to_frame(const HostClaim& claim, std::uint8_t node, std::uint16_t salt) noexcept {
  return make_frame(claim_id(node, salt), claim.key, static_cast<std::uint8_t>(claim.action), 0);
}

CanFrame to_frame(const HostGrant& grant, std::uint8_t node) noexcept {
  return make_frame(grant_id(node), grant.key, grant.address, grant.places);
}

bool from_frame(const CanFrame& frame, std::uint8_t node, HostClaim& claim) noexcept {
  if (!is_data_of(frame, claim_id(node), kClaimMask)) return false;
  const auto action = static_cast<ClaimAction>(frame.data[kKeyBytes]);
  if (key_of(frame) == 0 || (action != ClaimAction::kClaim && action != ClaimAction::kRelease)) return false;
  claim = {key_of(frame), action};
  return true;
}

bool from_frame(const CanFrame& frame, std::uint8_t node, HostGrant& grant) noexcept {
  constexpr std::uint32_t kEveryBit = 0x1FFF'FFFF;
  if (!is_data_of(frame, grant_id(node), kEveryBit) || key_of(frame) == 0) return false;
  grant = {key_of(frame), frame.data[kKeyBytes], frame.data[kKeyBytes + 1]};
  return true;
}

}  // namespace thimble::firmware::link
