#include "board/zynqmp/clock.h"

#include <gtest/gtest.h>

namespace thimble::board::clock {
namespace {

TEST(ZynqClock, MicrosecondsDoNotWrapInAYear) {
  constexpr std::uint32_t kHertz = 500'000'000;
  constexpr std::uint64_t kYear_s = 366ULL * 24 * 3600;
  EXPECT_EQ(to_micros(kYear_s * kHertz, kHertz), kYear_s * 1'000'000);
  EXPECT_EQ(to_micros(kYear_s * kHertz + 499'999'999, kHertz), kYear_s * 1'000'000 + 999'999);
  EXPECT_EQ(to_micros(750, kHertz), 1U);
}

}  // namespace
}  // namespace thimble::board::clock
