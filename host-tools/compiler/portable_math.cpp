#include "host-tools/compiler/portable_math.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace thimble::host::portable {
namespace {

// A number as the sum of two doubles.
struct Pair {
  double high;
  double low;
};

constexpr Pair kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr Pair kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

// Exact (Dekker 1971): the high part is the rounded sum or product.
Pair sum(double a, double b) {
  const double high = a + b;
  const double of_b = high - a;
  return {high, (a - (high - of_b)) + (b - of_b)};
}
Pair product(double a, double b) {
  const auto split = [](double x) {
    const double scaled = x * 134217729.0;  // 2^27 + 1
    const double high = scaled - (scaled - x);
    return Pair{high, x - high};
  };
  const double high = a * b;
  const Pair p = split(a), q = split(b);
  return {high, ((p.high * q.high - high) + p.high * q.low + p.low * q.high) + p.low * q.low};
}

// c[0] + c[1] x + c[2] x^2 + ...
template <std::size_t kTerms>
double polynomial(const std::array<double, kTerms>& c, double x) {
  double value = 0;
  for (std::size_t i = kTerms; i-- > 0;) value = value * x + c[i];
  return value;
}

// x less the nearest multiple of pi / 2, and which multiple it is, modulo 4. Cody and Waite 1980: pi / 2 in parts of 33 bits, whose
// products with a whole number below 2^20 are exact.
struct Reduced {
  Pair rest;
  int quadrant;
};
Reduced reduced(double x) {
  constexpr std::array<double, 3> kPart{0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69};
  constexpr double kRest = 8.4784276603689e-32;
  const double turns = std::floor(x / kHalfPi.high + 0.5);
  const Pair first = sum(x - turns * kPart[0], -turns * kPart[1]);
  const Pair second = sum(first.high, first.low - turns * kPart[2] - turns * kRest);
  return {second, static_cast<int>(turns - 4.0 * std::floor(turns / 4.0))};
}

// Taylor's series for at most pi / 4; what they leave out is below 1e-19.
double sine_of(const Pair& x) {
  constexpr std::array<double, 8> kTerms{
      -1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
      -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  const double square = x.high * x.high;
  return x.high + (x.high * square * polynomial(kTerms, square) + x.low * (1.0 - 0.5 * square));
}
double cosine_of(const Pair& x) {
  constexpr std::array<double, 8> kTerms{
      1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,          -1.0 / 3628800.0,
      1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0, -1.0 / 6402373705728000.0};
  const Pair square = product(x.high, x.high);
  const Pair most = sum(1.0, -0.5 * square.high);
  return most.high + (most.low - 0.5 * square.low - x.high * x.low +
                      square.high * square.high * polynomial(kTerms, square.high));
}

double of_quadrant(const Reduced& angle, int turn) {
  const int quadrant = (angle.quadrant + turn) % 4;
  const double value = quadrant % 2 == 0 ? sine_of(angle.rest) : cosine_of(angle.rest);
  return quadrant < 2 ? value : -value;
}

// The arc tangents of 0, 1/16 ... 1.
constexpr std::array<Pair, 17> kArcTangent = {{
    {0.0, 0.0},
    {0.06241880999595735, -1.5490756308295046e-18},
    {0.12435499454676144, -3.1253241424539383e-18},
    {0.18534794999569476, 4.180692268843079e-18},
    {0.24497866312686414, 1.0698755618734451e-17},
    {0.3028848683749714, -1.1010827903001369e-17},
    {0.35877067027057225, -2.4623815582638635e-17},
    {0.4124104415973873, -1.587652227770689e-17},
    {0.4636476090008061, 2.2698777452961687e-17},
    {0.5123894603107377, -2.5462781472855804e-17},
    {0.5585993153435624, -5.4556305485916264e-18},
    {0.6022873461349642, 2.950430737228402e-17},
    {0.6435011087932844, 1.5834785051444286e-17},
    {0.6823165548747481, 6.943223671560008e-18},
    {0.7188299996216245, -2.1478388444456983e-17},
    {0.7531512809621944, -2.4256934659182068e-17},
    {0.7853981633974483, 3.061616997868383e-17},
}};

// The arc tangent of least / most, which is at most 1: from the nearest known one, atan q = atan c + atan((q - c) / (1 + c q)).
Pair arc_tangent(double least, double most) {
  constexpr std::array<double, 9> kTerms{-1.0 / 3.0, 1.0 / 5.0,   -1.0 / 7.0, 1.0 / 9.0,  -1.0 / 11.0,
                                         1.0 / 13.0, -1.0 / 15.0, 1.0 / 17.0, -1.0 / 19.0};
  const double ratio = least / most;
  const Pair back = product(ratio, most);
  const double rest = ((least - back.high) - back.low) / most;  // that the quotient leaves
  const double nearest = std::floor(16.0 * ratio + 0.5);
  const double known = nearest < 2.0 ? 0.0 : nearest / 16.0;
  const double small = (ratio - known) / (1.0 + known * ratio);
  const double square = small * small;
  const Pair& known_arc = kArcTangent[static_cast<std::size_t>(16.0 * known)];
  const Pair whole = sum(known_arc.high, small);
  return {whole.high, whole.low + (small * square * polynomial(kTerms, square) + known_arc.low +
                                   rest / (1.0 + ratio * ratio))};
}

}  // namespace

double sin(double x) { return of_quadrant(reduced(x), 0); }
double cos(double x) { return of_quadrant(reduced(x), 1); }

double atan2(double y, double x) {
  const double up = std::abs(y), along = std::abs(x);
  if (up == 0.0) return std::copysign(std::signbit(x) ? kPi.high : 0.0, y);
  Pair angle = arc_tangent(std::min(up, along), std::max(up, along));
  const auto take_from = [&angle](const Pair& whole) {
    const Pair high = sum(whole.high, -angle.high);
    angle = {high.high, high.low + (whole.low - angle.low)};
  };
  if (up > along) take_from(kHalfPi);
  if (std::signbit(x)) take_from(kPi);
  return std::copysign(angle.high + angle.low, y);
}

}  // namespace thimble::host::portable
