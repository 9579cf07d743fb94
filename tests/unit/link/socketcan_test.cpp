// Linux's frames against its own header, and round trips.
#include "firmware/link/socketcan.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstring>

namespace thimble::firmware::link {
namespace {

TEST(SocketCan, AClassicFrameIsACanFrame) {
  CanFrame frame;
  frame.id = 0x18DA01F1;
  frame.extended = true;
  frame.size = 3;
  frame.data = {0x02, 0x3E, 0x80};
  canfd_frame raw;
  ASSERT_EQ(to_socketcan(frame, raw), sizeof(can_frame));
  can_frame classic;
  std::memcpy(&classic, &raw, sizeof(classic));
  EXPECT_EQ(classic.can_id, 0x18DA01F1U | CAN_EFF_FLAG);
  EXPECT_EQ(classic.can_dlc, 3);
  EXPECT_EQ(classic.data[1], 0x3E);
  EXPECT_EQ(classic.data[3], 0);

  frame = {};
  frame.id = 0x123;
  frame.remote = true;
  frame.size = 4;
  ASSERT_EQ(to_socketcan(frame, raw), sizeof(can_frame));
  EXPECT_EQ(raw.can_id, 0x123U | CAN_RTR_FLAG);
}

TEST(SocketCan, AnFdFrameSaysSoByItsLength) {
  CanFrame frame;
  frame.id = 0x7FF;
  frame.fd = frame.bit_rate_switch = true;
  frame.size = 64;
  frame.data.fill(0x5A);
  canfd_frame raw;
  ASSERT_EQ(to_socketcan(frame, raw), sizeof(canfd_frame));
  EXPECT_EQ(raw.can_id, 0x7FFU);
  EXPECT_EQ(raw.len, 64);
  EXPECT_EQ(raw.flags, CANFD_BRS);
  EXPECT_EQ(raw.data[63], 0x5A);
}

TEST(SocketCan, RoundTrips) {
  rc::check("what is written is read", [] {
    CanFrame frame;
    frame.extended = *rc::gen::arbitrary<bool>();
    frame.id = *rc::gen::inRange<std::uint32_t>(0, frame.extended ? 1U << 29U : 1U << 11U);
    frame.fd = *rc::gen::arbitrary<bool>();
    frame.bit_rate_switch = frame.fd && *rc::gen::arbitrary<bool>();
    frame.remote = !frame.fd && *rc::gen::arbitrary<bool>();
    frame.size =
        frame.fd ? fd_size(*rc::gen::inRange<std::size_t>(0, 65)) : *rc::gen::inRange<std::uint8_t>(0, 9);
    if (!frame.remote)
      for (std::size_t i = 0; i < frame.size; ++i) frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
    canfd_frame raw;
    const std::size_t bytes = to_socketcan(frame, raw);
    CanFrame read;
    RC_ASSERT(from_socketcan(raw, bytes, read));
    RC_ASSERT(read == frame);
  });
}

TEST(SocketCan, WhatIsNoFrameIsRefused) {
  CanFrame frame;
  canfd_frame raw{};
  EXPECT_TRUE(from_socketcan(raw, CAN_MTU, frame));
  for (const std::size_t bytes : {std::size_t{0}, CAN_MTU - 1, CAN_MTU + 1, CANFD_MTU - 1, CANFD_MTU + 1})
    EXPECT_FALSE(from_socketcan(raw, bytes, frame)) << bytes;
  raw.len = 9;  // longer than a classic frame; and no size of an FD frame
  EXPECT_FALSE(from_socketcan(raw, CAN_MTU, frame));
  EXPECT_FALSE(from_socketcan(raw, CANFD_MTU, frame));
  raw.len = 65;
  EXPECT_FALSE(from_socketcan(raw, CANFD_MTU, frame));
  raw.len = 8;
  raw.can_id = CAN_ERR_FLAG | 0x40U;  // bus off
  EXPECT_FALSE(from_socketcan(raw, CAN_MTU, frame));
}

}  // namespace
}  // namespace thimble::firmware::link
