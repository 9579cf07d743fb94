#include "host-tools/client/host_claim.h"

namespace thimble::host {
namespace {

// Well before the device ends the place: a request may be long on its way.
constexpr link::Micros kStale_us = link::kHostTimeout_us * 2 / 5;

std::uint64_t seed() {
  std::random_device device;
  return static_cast<std::uint64_t>(device()) << 32U | device();
}

}  // namespace

HostClaim::HostClaim(std::uint8_t node) : node_(node), random_(seed()) {
  do {
    key_ = random_() & link::kHostKeyMask;
  } while (key_ == 0);
}

link::CanFrame HostClaim::claim(link::Micros now) {
  claimed_us_ = now;
  return to_frame(link::HostClaim{key_, link::ClaimAction::kClaim}, node_,
                  static_cast<std::uint16_t>(random_()));
}

link::CanFrame HostClaim::release() {
  return to_frame(link::HostClaim{key_, link::ClaimAction::kRelease}, node_,
                  static_cast<std::uint16_t>(random_()));
}

HostClaim::Grant HostClaim::on_frame(const link::CanFrame& frame) {
  link::HostGrant grant;
  if (!link::from_frame(frame, node_, grant) || grant.key != key_) return Grant::kNone;
  if (grant.address == 0) return Grant::kRefused;
  // A late grant may answer an earlier claim: that one is older by less than kStale_us, or this program would not hear it.
  confirm(claimed_us_);
  if (grant.address == address_) return Grant::kSame;
  address_ = grant.address;
  return Grant::kNew;
}

bool HostClaim::stale(link::Micros now) const { return !granted() || now - confirmed_us_ > kStale_us; }

}  // namespace thimble::host
