// Valid and invalid lines of candump logs.
#include "host-tools/can_tools/can_log.h"

#include <gtest/gtest.h>

namespace thimble::host {
namespace {

TEST(CanLog, ALineOfEachKind) {
  const auto real_time = parse_log_line("(1700000000.123456) can0 181#0102030405060708");
  ASSERT_TRUE(real_time);
  EXPECT_DOUBLE_EQ(real_time->time_s, 1700000000.123456);
  EXPECT_EQ(real_time->interface, "can0");
  EXPECT_EQ(real_time->frame.id, 0x181U);
  EXPECT_FALSE(real_time->frame.extended);
  EXPECT_EQ(real_time->frame.size, 8);
  EXPECT_EQ(real_time->frame.data[7], 8);

  const auto service = parse_log_line("(0.000001) vcan0 18DA01F1##1023E00CCCCCCCCCC");
  ASSERT_TRUE(service);
  EXPECT_TRUE(service->frame.extended && service->frame.fd && service->frame.bit_rate_switch);
  EXPECT_EQ(service->frame.size, 8);

  const auto remote = parse_log_line(" (12.5) can1 7FF#R\r");
  ASSERT_TRUE(remote);
  EXPECT_TRUE(remote->frame.remote);

  const auto empty = parse_log_line("(12.5) can1 001#");
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->frame.size, 0);

  const auto error = parse_log_line("(12.5) can1 20000040#0000000000000000");
  ASSERT_TRUE(error);
  EXPECT_TRUE(error->error);

  EXPECT_TRUE(parse_log_line("(12.5) can1 181#00 T")) << "candump -x adds the direction";
}

TEST(CanLog, WhatIsNoLine) {
  for (const char* line :
       {"", "x", "(1.0)", "(1.0) can0", "(1.0) can0 181", "(1.0) can0 18#00", "(1.0) can0 181#0",
        "(1.0) can0 181#0G", "(1.0) can0 181#000000000000000000", "1.0 can0 181#00", "(1.0 can0 181#00",
        "(a) can0 181#00", "() can0 181#00", "(1.0) can0 FFF#00", "(1.0) can0 181##",
        "(1.0) can0 181##0000000000000000000", "(1.0) can0 1 8 1#00", "(1.0)can0 181#00"})
    EXPECT_FALSE(parse_log_line(line)) << line;
}

}  // namespace
}  // namespace thimble::host
