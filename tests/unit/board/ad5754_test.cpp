// Encoding for the AD5754R: the frames of its data sheet, the scale, and values outside the range.
#include "board/common/ad5754.h"

#include <gtest/gtest.h>

#include <limits>

namespace thimble::test {
namespace {

using board::Ad5754;

TEST(Ad5754, FramesAreThoseOfTheDataSheet) {
  EXPECT_EQ(Ad5754::set_range(), (Ad5754::Frame{0x0C, 0x00, 0x04}));  // 0 0 001 100, code 100: +-10 V
  EXPECT_EQ(Ad5754::power_up(), (Ad5754::Frame{0x10, 0x00, 0x1F}));   // 0 0 010 000
  EXPECT_EQ(Ad5754::load(), (Ad5754::Frame{0x1D, 0x00, 0x00}));       // 0 0 011 101
  EXPECT_EQ(Ad5754::voltage(0, 0x1234), (Ad5754::Frame{0x00, 0x12, 0x34}));
  EXPECT_EQ(Ad5754::voltage(2, -1), (Ad5754::Frame{0x02, 0xFF, 0xFF}));
}

TEST(Ad5754, ScaleAndOffset) {
  const Ad5754::Channel channel{2.0F, 0.0F};
  EXPECT_EQ(Ad5754::word(channel, 0.0F).value, 0);
  EXPECT_EQ(Ad5754::word(channel, 2.5F).value, 16384);  // 5 V of 10
  EXPECT_EQ(Ad5754::word(channel, -2.5F).value, -16384);
  EXPECT_EQ(Ad5754::word({-2.0F, 0.0F}, 2.5F).value, -16384);
  EXPECT_EQ(Ad5754::word({2.0F, 0.1F}, 0.0F).value, 328);  // 0.1 V
  EXPECT_EQ(Ad5754::word({2.0F, -0.1F}, 0.0F).value, -328);
  // Every step can be reached, and half a step is the error.
  for (int word = -32768; word <= 32767; ++word) {
    const float current_A = static_cast<float>(word) * 10.0F / 32768.0F / channel.volts_per_ampere;
    ASSERT_EQ(Ad5754::word(channel, current_A).value, word);
    ASSERT_FALSE(Ad5754::word(channel, current_A).which);
  }
}

TEST(Ad5754, BeyondTheRangeIsItsEndAndSaysSo) {
  const Ad5754::Channel channel{2.0F, 0.0F};
  EXPECT_EQ(Ad5754::word(channel, 5.1F).value, INT16_MAX);
  EXPECT_TRUE(Ad5754::word(channel, 5.1F).which);
  EXPECT_EQ(Ad5754::word(channel, -5.1F).value, INT16_MIN);
  EXPECT_TRUE(Ad5754::word(channel, -5.1F).which);
  EXPECT_EQ(Ad5754::word(channel, 1e30F).value, INT16_MAX);
}

TEST(Ad5754, NotANumberDrivesNoCurrent) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(Ad5754::word({2.0F, 0.1F}, bad).value, 328);
    EXPECT_TRUE(Ad5754::word({2.0F, 0.1F}, bad).which);
  }
}

}  // namespace
}  // namespace thimble::test
