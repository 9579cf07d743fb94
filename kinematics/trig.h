// Own sine, cosine and arcsine: those of libm differ in the last bit between targets, and the tick must give
// the same bytes on every target. Errors: sin_cos below 1e-7 (float) and 3e-16 (double) over [-kMaxAngle,
// kMaxAngle]; arc_sine below 2e-7. An argument outside the range (or NaN) gives NaN, which the finite check
// of the tick detects. No tables, no loops.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

namespace thimble::kinematics {

template <typename S>
struct SinCos {
  S sin, cos;
};

inline constexpr double kMaxAngle =
    12.6;  // slightly more than two turns in either direction; joint angles stay within one turn

template <typename S>
[[nodiscard]] constexpr SinCos<S> sin_cos(S angle) noexcept {
  static_assert(std::is_same_v<S, float> || std::is_same_v<S, double>);
  constexpr bool kDouble = std::is_same_v<S, double>;
  if (!(angle >= S(-kMaxAngle) && angle <= S(kMaxAngle))) {
    return {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::quiet_NaN()};
  }
  // r = angle - n pi/2, |r| <= pi/4. pi/2 is split into three parts; the first two have few enough bits that
  // their product with n is exact (Cody, Waite).
  const S quarters = angle * S(.636619772367581343);
  const int n = static_cast<int>(quarters + (quarters >= 0 ? S(.5) : S(-.5)));
  const S k = static_cast<S>(n);
  const S r = kDouble ? ((angle - k * S(1.5707963267341256)) - k * S(6.077100506303966e-11)) -
                            k * S(2.0222662487959506e-21)
                      : ((angle - k * S(1.5707950592041016)) - k * S(1.2675900507019833e-06)) -
                            k * S(7.443547480486623e-13);
  // Taylor series: the first omitted term is below 2e-9 (float) and 2e-18 (double) at pi/4.
  const S z = r * r;
  S s, c;
  if constexpr (kDouble) {
    s = ((((((z / -1307674368000.0 + 1.0 / 6227020800.0) * z - 1.0 / 39916800.0) * z + 1.0 / 362880.0) * z -
           1.0 / 5040.0) *
              z +
          1.0 / 120.0) *
             z -
         1.0 / 6.0);
    c = ((
        (((((z / 20922789888000.0 - 1.0 / 87178291200.0) * z + 1.0 / 479001600.0) * z - 1.0 / 3628800.0) * z +
          1.0 / 40320.0) *
             z -
         1.0 / 720.0) *
            z +
        1.0 / 24.0));
  } else {
    s = ((z / 362880.0F - 1.0F / 5040.0F) * z + 1.0F / 120.0F) * z - 1.0F / 6.0F;
    c = ((z / -3628800.0F + 1.0F / 40320.0F) * z - 1.0F / 720.0F) * z + 1.0F / 24.0F;
  }
  const S sine = r + r * z * s;
  const S cosine = (S(1) - S(.5) * z) + z * z * c;
  switch (n & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

// Arcsine of x from 0 to 1, in radians; NaN outside.
[[nodiscard]] inline float arc_sine(float x) noexcept {
  if (!(x >= 0.0F && x <= 1.0F)) return std::numeric_limits<float>::quiet_NaN();
  const bool upper = x > 0.5F;  // asin x = pi/2 - 2 asin sqrt((1 - x) / 2)
  const float z = upper ? 0.5F * (1.0F - x) : x * x;
  const float s = upper ? std::sqrt(z) : x;
  // Taylor series: the first omitted term is below 6e-8 of the result at s = 1/2.
  float sum = 2027025.0F / 175472640.0F;
  sum = sum * z + 135135.0F / 9676800.0F;
  sum = sum * z + 10395.0F / 599040.0F;
  sum = sum * z + 945.0F / 42240.0F;
  sum = sum * z + 105.0F / 3456.0F;
  sum = sum * z + 15.0F / 336.0F;
  sum = sum * z + 3.0F / 40.0F;
  sum = sum * z + 1.0F / 6.0F;
  const float arc = s + s * z * sum;
  return upper ? std::numbers::pi_v<float> / 2.0F - 2.0F * arc : arc;
}

}  // namespace thimble::kinematics
