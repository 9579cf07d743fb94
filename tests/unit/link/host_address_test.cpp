// Addresses of hosts on the wire: the frames of a claim, as docs/link.md has them.
#include "firmware/link/host_address.h"

#include <gtest/gtest.h>

#include <set>

namespace thimble::firmware::link {
namespace {

TEST(HostAddress, IdentifiersOfRequestsAndAnswers) {
  EXPECT_EQ(request_id(5, 0xF7), 0x18DA05F7U);
  EXPECT_EQ(response_id(5, 0xF7), 0x18DAF705U);
  std::set<std::uint32_t> ids = {request_id(5), response_id(5), grant_id(5), claim_id(5)};
  for (unsigned host = kFirstHostAddress; host <= kLastHostAddress; ++host) {
    const auto address = static_cast<std::uint8_t>(host);
    EXPECT_TRUE(ids.insert(request_id(5, address)).second);
    EXPECT_TRUE(ids.insert(response_id(5, address)).second);
    EXPECT_EQ(request_id(5, address) & kRequestMask, request_id(5) & kRequestMask);
    EXPECT_NE(request_id(4, address) & kRequestMask, request_id(5) & kRequestMask);
    EXPECT_NE(response_id(5, address) & kRequestMask, request_id(5) & kRequestMask);
  }
}

TEST(HostAddress, AClaimAsBytes) {
  const CanFrame frame = to_frame(HostClaim{0x0605'0403'0201, ClaimAction::kClaim}, 9, 0xABCD);
  EXPECT_EQ(frame.id, 0x1CABCD09U);
  EXPECT_TRUE(frame.extended);
  EXPECT_TRUE(is_valid(frame));
  const std::array<std::uint8_t, 8> bytes = {1, 2, 3, 4, 5, 6, 1, 0};
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), frame.bytes().begin(), frame.bytes().end()));
}

TEST(HostAddress, AGrantAsBytes) {
  const CanFrame frame = to_frame(HostGrant{0x0605'0403'0201, 0xF4}, 9);
  EXPECT_EQ(frame.id, 0x1D000009U);
  EXPECT_TRUE(is_valid(frame));
  const std::array<std::uint8_t, 8> bytes = {1, 2, 3, 4, 5, 6, 0xF4, 4};
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), frame.bytes().begin(), frame.bytes().end()));
}

TEST(HostAddress, ReadsWhatItWroteForItsNodeOnly) {
  for (const ClaimAction action : {ClaimAction::kClaim, ClaimAction::kRelease}) {
    for (const int salt : {0, 1, 0x7FFF, 0xFFFF}) {
      const CanFrame frame = to_frame(HostClaim{kHostKeyMask, action}, 7, static_cast<std::uint16_t>(salt));
      HostClaim claim;
      ASSERT_TRUE(from_frame(frame, 7, claim));
      EXPECT_EQ(claim.key, kHostKeyMask);
      EXPECT_EQ(claim.action, action);
      EXPECT_FALSE(from_frame(frame, 6, claim));
      HostGrant grant;
      EXPECT_FALSE(from_frame(frame, 7, grant));
    }
  }
  const CanFrame frame = to_frame(HostGrant{3, 0xF2}, 7);
  HostGrant grant;
  ASSERT_TRUE(from_frame(frame, 7, grant));
  EXPECT_EQ(grant.key, 3U);
  EXPECT_EQ(grant.address, 0xF2);
  EXPECT_EQ(grant.places, kMaxHosts);
  EXPECT_FALSE(from_frame(frame, 8, grant));
  HostClaim claim;
  EXPECT_FALSE(from_frame(frame, 7, claim));
}

TEST(HostAddress, WhatIsNoClaimIsNotTaken) {
  const CanFrame sound = to_frame(HostClaim{1, ClaimAction::kClaim}, 1, 0);
  HostClaim claim;
  CanFrame frame = sound;
  frame.size = 7;
  EXPECT_FALSE(from_frame(frame, 1, claim)) << "cut short on its way";
  frame = sound;
  frame.extended = false;
  EXPECT_FALSE(from_frame(frame, 1, claim));
  frame = sound;
  frame.remote = true;
  EXPECT_FALSE(from_frame(frame, 1, claim));
  frame = sound;
  frame.data[6] = 3;
  EXPECT_FALSE(from_frame(frame, 1, claim)) << "no such action";
  frame = sound;
  frame.data[0] = 0;
  EXPECT_FALSE(from_frame(frame, 1, claim)) << "no key";
  frame = to_frame(HostGrant{0, 0xF2}, 1);
  HostGrant grant;
  EXPECT_FALSE(from_frame(frame, 1, grant));
}

}  // namespace
}  // namespace thimble::firmware::link
