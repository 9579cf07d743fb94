#include "firmware/core/encoder_probe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace thimble::firmware {
namespace {

constexpr float kPeriod_s = 1.0F / 4000;

// When an encoder that does not count is found dead; infinite: not in 3 s. holds: whether the joint has its share of the force.
float found_s(const std::function<bool(float time_s)>& holds) {
  EncoderProbe probe;
  for (int k = 0; k < 12000; ++k) {
    const float time_s = static_cast<float>(k) * kPeriod_s;
    probe.watch(0,
                {.counts = 7, .pushes_up = true, .holds = holds(time_s), .changed = true, .may_rest = true},
                kPeriod_s);
    if (probe.dead()) return time_s;
  }
  return INFINITY;
}

TEST(EncoderProbe, FindsADeadEncoderWithAForceThatStaysOrAlternates) {
  EXPECT_LT(found_s([](float) { return true; }), .2F);
  for (const float Hz : {2.0F, 5.0F, 12.0F, 20.0F, 50.0F, 100.0F}) {
    const auto alternates = [Hz](float time_s) {
      return std::abs(3 * std::sin(2 * std::numbers::pi_v<float> * Hz * time_s)) > .4F;
    };
    EXPECT_LT(found_s(alternates), .6F) << Hz;
  }
}

// As on a wall that swings: the share comes in peaks, and on average it is too small to move a sound joint when it is taken away.
TEST(EncoderProbe, ThatAShareComesInPeaksProvesNothing) {
  for (const float on_s : {.002F, .01F, .02F})
    EXPECT_EQ(found_s([on_s](float time_s) { return std::fmod(time_s, 2 * on_s) < on_s; }), INFINITY) << on_s;
}

}  // namespace
}  // namespace thimble::firmware
