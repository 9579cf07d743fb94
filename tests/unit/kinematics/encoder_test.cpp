#include "kinematics/encoder.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace thimble::kinematics {
namespace {

constexpr float kTick_s = 1.0F / 4000.0F;

ArmModel premium(CounterWidth width, float sign = 1.0F) {
  ArmModel m = *find_arm_model("premium-1.5");
  m.counter_width = width;
  for (JointModel& j : m.joint) j.sign = sign;
  return m;
}

class Wrap : public testing::TestWithParam<CounterWidth> {};

TEST_P(Wrap, BothWaysThroughZeroAndHalf) {
  const bool narrow = GetParam() == CounterWidth::k16;
  const std::uint32_t mask = narrow ? 0xFFFFU : 0xFFFFFFFFU;
  for (const std::uint32_t start :
       {std::uint32_t{0}, std::uint32_t{3}, mask, mask / 2, mask / 2 + 1, mask - 5}) {
    for (const int step : {1, -1, 17, -17}) {
      JointEncoder encoder(premium(GetParam()), 0, kTick_s);
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
INSTANTIATE_TEST_SUITE_P(Widths, Wrap, testing::Values(CounterWidth::k16, CounterWidth::k32));

TEST(JointEncoder, SignTransmissionAndHome) {
  const ArmModel m = premium(CounterWidth::k32, -1.0F);
  JointEncoder encoder(m, 0, kTick_s);
  encoder.home(1000, 0.25F);
  EXPECT_FLOAT_EQ(encoder.angle_rad(), 0.25F);
  std::uint32_t raw = 1000;
  const auto turn = static_cast<std::uint32_t>(4096 * 13.3 / 4);  // a quarter turn of joint 1
  for (std::uint32_t k = 0; k < turn; ++k) ASSERT_EQ(encoder.update(++raw), EncoderStatus::kOk);
  EXPECT_NEAR(encoder.angle_rad(), 0.25F - kPi / 2, 2e-4F);
}

TEST(JointEncoder, AJumpIsRefusedAndTheAngleStays) {
  for (const CounterWidth width : {CounterWidth::k16, CounterWidth::k32}) {
    const ArmModel m = premium(width);
    JointEncoder encoder(m, 1, kTick_s);
    encoder.home(100, 0.0F);
    const std::int32_t most = encoder.max_counts_per_tick();
    std::printf("most counts a tick at 4 kHz: %d\n", most);
    // The joint's top speed and no more than one count beyond.
    EXPECT_GE(static_cast<float>(most), m.max_joint_speed_rad_s * kTick_s / encoder.rad_per_count());
    EXPECT_LE(static_cast<float>(most - 1), m.max_joint_speed_rad_s * kTick_s / encoder.rad_per_count());
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
