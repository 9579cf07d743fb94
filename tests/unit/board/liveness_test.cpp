// Liveness: a watchdog is fed while every context makes progress, and not when any single one hangs.
#include "board/common/liveness.h"

#include <gtest/gtest.h>

namespace thimble::test {
namespace {

using board::Liveness;

constexpr std::array<std::uint32_t, 3> kLimits_us = {100, 200, 300};

TEST(Liveness, EveryContextMustBeat) {
  for (std::size_t hangs = 0; hangs < kLimits_us.size(); ++hangs) {
    Liveness<3> liveness(kLimits_us);
    std::uint64_t now_us = 5'000'000'000;  // beyond 32 bits
    EXPECT_TRUE(liveness.alive(now_us));
    for (int round = 0; round < 100; ++round) {
      for (std::size_t i = 0; i < kLimits_us.size(); ++i) liveness.beat(i);
      now_us += 50;
      EXPECT_TRUE(liveness.alive(now_us));
    }
    std::uint64_t since_us = 0;
    while (liveness.alive(now_us)) {
      for (std::size_t i = 0; i < kLimits_us.size(); ++i)
        if (i != hangs) liveness.beat(i);
      now_us += 10;
      since_us += 10;
      ASSERT_LE(since_us, 1000U);
    }
    EXPECT_EQ(since_us, kLimits_us[hangs] + 10);
    EXPECT_EQ(liveness.hanging(now_us), 1U << hangs);
    liveness.beat(hangs);
    EXPECT_TRUE(liveness.alive(now_us));
  }
}

TEST(Liveness, AContextThatNeverBeganHangsToo) {
  Liveness<3> liveness(kLimits_us);
  EXPECT_TRUE(liveness.alive(1000));
  EXPECT_TRUE(liveness.alive(1100));
  EXPECT_FALSE(liveness.alive(1101));
}

}  // namespace
}  // namespace thimble::test
