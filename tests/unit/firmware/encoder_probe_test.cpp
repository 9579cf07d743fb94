#include "firmware/core/encoder_probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

// A joint that is pushed up against a hand's spring. Who leads the hand sees late that the joint has moved, and moves the hand back.
struct Steered {
  float delay_s;    // from what is seen to the hand's answer; as long after that it looks again
  float gain;       // the share of what it has seen by which it moves the hand
  float move;       // counts by which the whole torque moves the joint
  float friction;   // of the joint, in counts
  float edge;       // the part of a count where the joint is at first
  float motor = 1;  // -1: reversed
};

// What the probe says of a joint whose encoder works, in 4 s.
enum class Said { kNothing, kDead, kReversed };
Said said(const Steered& it) {
  EncoderProbe probe;
  const auto late = static_cast<int>(it.delay_s / kPeriod_s);
  const float start = 100 + it.edge;
  float hand = start - it.motor * it.move;
  float place = start;
  float seen = 0;  // how far the joint was from where it is wanted, at the last look
  for (int k = 0; k < 16000; ++k) {
    const float rest = hand + it.motor * it.move * probe.part(0);
    place = std::clamp(place, rest - it.friction, rest + it.friction);
    if (k % (2 * late) == 0) seen = start - place;
    if (k % (2 * late) == late) hand += it.gain * seen;
    const auto counts = static_cast<std::int32_t>(std::floor(place));
    probe.watch(0, {.counts = counts, .pushes_up = true, .holds = true, .changed = false, .may_rest = false},
                kPeriod_s);
    if (probe.reversed(0)) return Said::kReversed;
    if (probe.dead()) return Said::kDead;
  }
  return Said::kNothing;
}

// A person takes 150 ms to answer what is seen or felt. A program may answer within 4 to 50 ms, and can then bring a sound joint back as a
// reversed motor does: the probe cannot tell.
TEST(EncoderProbe, AHandThatCountersAProbeAsFastAsAPersonIsNoReversedMotor) {
  for (const float delay_s : {.15F, .2F, .3F})
    for (const float gain : {.25F, .5F, 1.0F})
      for (const float moves : {EncoderProbe::kCounts, 10.0F, 40.0F})
        for (const float friction : {0.0F, .5F, 1.0F})
          for (const float edge : {.05F, .5F, .95F})
            EXPECT_EQ(said({delay_s, gain, moves + 2 * friction, friction, edge}), Said::kNothing)
                << delay_s << " s, gain " << gain << ", " << moves << " counts, friction " << friction
                << ", edge " << edge;
}

TEST(EncoderProbe, AReversedMotorIsToldWhateverTheHandDoes) {
  for (const float gain : {0.0F, .5F, 1.0F})
    for (const float move : {4.0F, 10.0F, 40.0F})
      EXPECT_EQ(said({.15F, gain, move, .5F, .5F, -1}), Said::kReversed)
          << "gain " << gain << ", " << move << " counts";
}

}  // namespace
}  // namespace thimble::firmware
