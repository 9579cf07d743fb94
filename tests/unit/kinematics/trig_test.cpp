#include "kinematics/trig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace thimble::kinematics {
namespace {

double ulp(float x) {
  const float magnitude = std::max(std::abs(x), 1e-30F);
  return static_cast<double>(std::nextafter(magnitude, 2.0F) - magnitude);
}

// Every float whose bits end in a fixed pattern, from 2^-20 to two turns, both signs, and the neighbours of
// the zeros.
TEST(Trig, FloatIsWithinTwoUlp) {
  double worst_ulp = 0, worst = 0;
  long angles = 0;
  const auto probe = [&](float x) {
    const SinCos<float> s = sin_cos(x);
    const double exact_sin = std::sin(static_cast<double>(x)), exact_cos = std::cos(static_cast<double>(x));
    const double sin_error = std::abs(static_cast<double>(s.sin) - exact_sin);
    const double cos_error = std::abs(static_cast<double>(s.cos) - exact_cos);
    worst = std::max({worst, sin_error, cos_error});
    worst_ulp = std::max({worst_ulp, sin_error / ulp(static_cast<float>(exact_sin)),
                          cos_error / ulp(static_cast<float>(exact_cos))});
    ++angles;
  };
  const auto last = std::bit_cast<std::uint32_t>(static_cast<float>(2 * M_PI));
  for (auto bits = std::bit_cast<std::uint32_t>(0x1p-20F); bits <= last; bits += 61) {
    probe(std::bit_cast<float>(bits));
    probe(-std::bit_cast<float>(bits));
  }
  for (int quarter = -8; quarter <= 8; ++quarter) {
    auto x = static_cast<float>(quarter * M_PI / 2);
    for (int k = 0; k < 2000; ++k) x = std::nextafter(x, -20.0F);
    for (int k = 0; k < 4000; ++k) probe(x = std::nextafter(x, 20.0F));
  }
  std::printf("float sin and cos: worst error %.3g, %.2f ulp over %ld angles\n", worst, worst_ulp, angles);
  EXPECT_LE(worst, 1.2e-7);
  EXPECT_LE(worst_ulp, 2.0);
}

TEST(Trig, DoubleIsWithinAFewUlpOfOne) {
  double worst = 0;
  for (int k = -1000000; k <= 1000000; ++k) {
    const double x = k * 1.2e-5;
    const SinCos<double> s = sin_cos(x);
    worst = std::max({worst, std::abs(s.sin - std::sin(x)), std::abs(s.cos - std::cos(x))});
  }
  std::printf("double sin and cos: worst error %.3g\n", worst);
  EXPECT_LE(worst, 3e-16);
}

TEST(Trig, OutOfRangeIsNaN) {
  for (const float x : {13.0F, -13.0F, 1e30F, INFINITY, -INFINITY, NAN}) {
    EXPECT_TRUE(std::isnan(sin_cos(x).sin)) << x;
    EXPECT_TRUE(std::isnan(sin_cos(x).cos)) << x;
  }
}

TEST(Trig, ArcSineIsThatOfTheLibrary) {
  double worst = 0;
  for (int k = 0; k <= 1 << 20; ++k) {
    const float x = static_cast<float>(k) * 0x1p-20F;
    worst = std::max(worst, std::abs(static_cast<double>(arc_sine(x)) - std::asin(static_cast<double>(x))));
  }
  EXPECT_LT(worst, 2e-7);
  for (const float x : {-1e-6F, 1.000001F, INFINITY, NAN}) EXPECT_TRUE(std::isnan(arc_sine(x))) << x;
}

// The same bits on every target: a digest over a sweep, so that a target (or a compiler flag) that rounds
// otherwise is seen.
TEST(Trig, BitsAreTheSameEverywhere) {
  std::uint64_t digest = 14695981039346656037U;
  for (int k = -100000; k <= 100000; ++k) {
    const SinCos<float> s = sin_cos(static_cast<float>(k) * 0x1p-14F);
    for (const float v : {s.sin, s.cos}) digest = (digest ^ std::bit_cast<std::uint32_t>(v)) * 1099511628211U;
  }
  std::printf("digest %016llx\n", static_cast<unsigned long long>(digest));
  EXPECT_EQ(digest, 0x0b5ef4a51a81ba85U);
}

}  // namespace
}  // namespace thimble::kinematics
