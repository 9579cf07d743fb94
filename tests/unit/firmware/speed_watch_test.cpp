// What moves faster than a hand is a fault, but for the motors that follow the stretch of the cables.
#include "firmware/core/speed_watch.h"

#include <gtest/gtest.h>

namespace thimble::test {
namespace {

using firmware::SpeedWatch;
constexpr float kLimit_m_s = 1.0F, kPeriod_s = 1e-3F;

// After a pause with one force: whether this speed with the other one is a fault, and for how many ticks it is none.
int ticks_without_fault(const Vec3& before_N, const Vec3& after_N, float speed_m_s) {
  SpeedWatch watch;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(watch.too_fast(0.1F, before_N, kLimit_m_s, kPeriod_s));
  int ticks = 0;
  while (ticks < 100 && !watch.too_fast(speed_m_s, after_N, kLimit_m_s, kPeriod_s)) ++ticks;
  return ticks;
}

TEST(SpeedWatch, MotorsFollowAForceThatChangesAtOnce) {
  EXPECT_EQ(ticks_without_fault({4, 0, 0}, {4, 0, 0}, 1.2F), 0);
  EXPECT_GE(ticks_without_fault({4, 0, 0}, {1, 0, 0}, 1.2F), 5) << "falls";
  EXPECT_GE(ticks_without_fault({4, 0, 0}, {0, 0, 4}, 1.2F), 5) << "turns, as great as before";
}

TEST(SpeedWatch, ButNotForLongNorAtTwiceTheLimit) {
  EXPECT_EQ(ticks_without_fault({4, 0, 0}, {0, 0, 4}, 2.1F), 0);
  EXPECT_LE(ticks_without_fault({4, 0, 0}, {0, 0, 4}, 1.3F), 40);
  EXPECT_EQ(ticks_without_fault({4, 0, 0}, {3, 0, 1}, 1.2F), 0) << "a small change";
}

// Another arming begins anew.
TEST(SpeedWatch, ForgetsTheForceBeforeIt) {
  SpeedWatch watch;
  EXPECT_FALSE(watch.too_fast(0, {4, 0, 0}, kLimit_m_s, kPeriod_s));
  watch.reset();
  EXPECT_TRUE(watch.too_fast(1.2F, {0.5F, 0, 0}, kLimit_m_s, kPeriod_s));
}

}  // namespace
}  // namespace thimble::test
