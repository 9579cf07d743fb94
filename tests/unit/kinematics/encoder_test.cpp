#include "kinematics/encoder.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "kinematics/built_in_arms.h"

namespace thimble::kinematics {
namespace {

constexpr float kTick_s = 1.0F / 4000.0F;

JointEncoder premium(std::size_t joint, std::uint8_t bits, float sign = 1.0F) {
  const ArmData arm = built_in_arm("premium-1.5");
  AxisData axis = arm.axis[joint];
  axis.counter_bits = bits;
  axis.encoder_sign = sign;
  return JointEncoder(axis, arm.max_joint_speed_rad_s, kTick_s);
}

class Wrap : public testing::TestWithParam<int> {};  // bits of the counter

TEST_P(Wrap, BothWaysThroughZeroAndHalf) {
  const auto bits = static_cast<std::uint8_t>(GetParam());
  const std::uint32_t mask = UINT32_MAX >> (32U - bits);
  for (const std::uint32_t start :
       {std::uint32_t{0}, std::uint32_t{3}, mask, mask / 2, mask / 2 + 1, mask - 5}) {
    for (const int step : {1, -1, 17, -17}) {
      JointEncoder encoder = premium(0, bits);
      encoder.home(start, 0.5F);
      std::uint32_t raw = start;
      // Far enough that a 16-bit counter wraps more than once.
      const int ticks = 10000;
      for (int k = 0; k < ticks; ++k) {
        raw = (raw + static_cast<std::uint32_t>(step)) & mask;
        ASSERT_EQ(encoder.update(raw), EncoderStatus::kOk);
      }
      EXPECT_EQ(encoder.counts(), step * ticks);
      EXPECT_FLOAT_EQ(encoder.angle_rad(), 0.5F + static_cast<float>(step * ticks) * encoder.rad_per_count());
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Widths, Wrap, testing::Values(8, 12, 16, 24, 32));

TEST(JointEncoder, SignTransmissionAndHome) {
  JointEncoder encoder = premium(0, 32, -1.0F);
  encoder.home(1000, 0.25F);
  EXPECT_FLOAT_EQ(encoder.angle_rad(), 0.25F);
  std::uint32_t raw = 1000;
  const auto turn = static_cast<std::uint32_t>(4096 * 13.3 / 4);  // a quarter turn of joint 1
  for (std::uint32_t k = 0; k < turn; ++k) ASSERT_EQ(encoder.update(++raw), EncoderStatus::kOk);
  EXPECT_NEAR(encoder.angle_rad(), 0.25F - kPi / 2, 2e-4F);
}

TEST(JointEncoder, AJumpIsRefusedAndTheAngleStays) {
  const float top_rad_s = built_in_arm("premium-1.5").max_joint_speed_rad_s;
  for (const int bits : {16, 32}) {
    JointEncoder encoder = premium(1, static_cast<std::uint8_t>(bits));
    encoder.home(100, 0.0F);
    const std::int32_t most = encoder.max_counts_per_tick();
    std::printf("most counts a tick at 4 kHz: %d\n", most);
    // The joint's top speed and no more than one count beyond.
    EXPECT_GE(static_cast<float>(most), top_rad_s * kTick_s / encoder.rad_per_count());
    EXPECT_LE(static_cast<float>(most - 1), top_rad_s * kTick_s / encoder.rad_per_count());
    EXPECT_EQ(encoder.update(static_cast<std::uint32_t>(100 + most)), EncoderStatus::kOk);
    const float angle = encoder.angle_rad();
    EXPECT_EQ(encoder.update(static_cast<std::uint32_t>(100 + 2 * most + 1)), EncoderStatus::kJump);
    EXPECT_EQ(encoder.update(static_cast<std::uint32_t>(100 - 1)), EncoderStatus::kJump);
    EXPECT_EQ(encoder.angle_rad(), angle);
    EXPECT_EQ(encoder.update(static_cast<std::uint32_t>(100 + most - 1)), EncoderStatus::kOk);
  }
}

}  // namespace
}  // namespace thimble::kinematics
