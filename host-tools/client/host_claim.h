// The address of this program on a device's link (firmware/link/host_address.h): claimed when it connects, confirmed by every
// answer, claimed again when the device has not been heard for a while, released at the end. Used by ServiceClient.
//
// It makes frames and takes grants; it neither sends nor waits. Nothing here can fail.
#pragma once

#include <cstdint>
#include <random>

#include "firmware/link/can_frame.h"
#include "firmware/link/host_address.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

class HostClaim {
 public:
  explicit HostClaim(std::uint8_t node);

  // The next claim; `now` counts as the time of its grant.
  [[nodiscard]] link::CanFrame claim(link::Micros now);
  [[nodiscard]] link::CanFrame release();

  enum class Grant { kNone, kSame, kNew, kRefused };
  // What a frame says of this program's claim. kNew: address() is another one now.
  Grant on_frame(const link::CanFrame& frame);

  // The device has given the address to another host: there is none until one is granted again.
  void forget() { address_ = link::kTesterAddress; }

  // link::kTesterAddress until one was granted.
  [[nodiscard]] std::uint8_t address() const { return address_; }
  [[nodiscard]] bool granted() const { return address_ != link::kTesterAddress; }
  // The device answered a request that left at this time.
  void confirm(link::Micros asked_us) { confirmed_us_ = std::max(confirmed_us_, asked_us); }
  // The device may have given the place to another host soon, or has done so: claim again before the next request.
  [[nodiscard]] bool stale(link::Micros now) const;

 private:
  std::uint8_t node_;
  std::mt19937_64 random_;
  std::uint64_t key_;
  std::uint8_t address_ = link::kTesterAddress;
  link::Micros claimed_us_ = 0;
  link::Micros confirmed_us_ = 0;
};

}  // namespace thimble::host
