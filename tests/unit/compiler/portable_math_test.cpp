// The compiler's own sine, cosine and arc tangent against long double, and that the compiler uses no others.
#include "host-tools/compiler/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <regex>
#include <string>

#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

namespace portable = host::portable;

// In units of the last place of the exact value, as a double.
double off(double value, long double exact) {
  if (static_cast<long double>(value) == exact) return 0.0;
  const double size = std::max(static_cast<double>(std::abs(exact)), std::numeric_limits<double>::min());
  const double unit = std::ldexp(1.0, std::ilogb(size) - 52);
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact)) / unit;
}

// long double has to be longer than double, and libm's functions for it right to the last bits.
static_assert(std::numeric_limits<long double>::digits >= 64);

TEST(PortableMath, SineAndCosineAreWithinAUnitOfTheLastPlace) {
  Random random(1);
  double most = 0.0;
  const auto compare = [&](double x) {
    most = std::max(most, off(portable::sin(x), std::sin(static_cast<long double>(x))));
    most = std::max(most, off(portable::cos(x), std::cos(static_cast<long double>(x))));
  };
  for (int i = 0; i < 100'000; ++i) {
    compare(random.uniform(-std::numbers::pi, std::numbers::pi));
    compare(random.uniform(-1.0e4, 1.0e4));
    compare(std::ldexp(random.uniform(-1.0, 1.0), -static_cast<int>(random.below(60))));
  }
  for (int turn = -6366; turn <= 6366; ++turn) {  // where one of them is nearly 0, and between the quadrants
    for (const double share : {0.5, 0.25}) {
      const double x = turn * share * std::numbers::pi;
      compare(x);
      compare(std::nextafter(x, 1.0e5));
      compare(std::nextafter(x, -1.0e5));
    }
  }
  for (const double x : {1.0e4, -1.0e4, 1.0e-300, 5.0e-324}) compare(x);
  EXPECT_LT(figure("sine and cosine: most units of the last place", most, "below 0.8"), 0.8);
  EXPECT_EQ(portable::sin(0.0), 0.0);
  EXPECT_EQ(portable::cos(0.0), 1.0);
}

TEST(PortableMath, ArcTangentIsWithinAUnitOfTheLastPlace) {
  Random random(2);
  double most = 0.0;
  const auto compare = [&](double y, double x) {
    most = std::max(most, off(portable::atan2(y, x),
                              std::atan2(static_cast<long double>(y), static_cast<long double>(x))));
  };
  for (int i = 0; i < 150'000; ++i) {
    compare(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const auto scaled = [&] {
      return std::ldexp(random.uniform(-1.0, 1.0), static_cast<int>(random.below(200)) - 100);
    };
    compare(scaled(), scaled());
    const double x = scaled();
    const double tangent =
        static_cast<double>(1 + random.below(33)) / 32.0;  // known ones, and the borders between them
    compare(std::nextafter(tangent * x, random.uniform(-1.0, 1.0)), x);
    compare(tangent * x, x);
  }
  for (const double y : {1.0, -1.0, 1.0e150, -1.0e-150, 3.0})
    for (const double x : {1.0, -1.0, 0.0, -0.0, 1.0e150, -1.0e-150, 1.0e-150}) compare(y, x);
  EXPECT_LT(figure("arc tangent: most units of the last place", most, "below 1"), 1.0);
  for (const double y : {0.0, -0.0}) {
    for (const double x : {0.0, -0.0, 1.0, -1.0}) {
      EXPECT_EQ(portable::atan2(y, x), std::atan2(y, x));
      EXPECT_EQ(std::signbit(portable::atan2(y, x)), std::signbit(y));
    }
  }
}

// Exact ones, such as sqrt, floor, round, ilogb and ldexp, may stay.
TEST(PortableMath, TheCompilerNamesNoFunctionThatALibmMayRoundDifferently) {
  namespace fs = std::filesystem;
  const std::regex inexact(
      R"((^|[^\w:.>]|std::|numext::|\.|Eigen::)(a?(sin|cos|tan)h?|atan2|sincos|pow|hypot|exp|exp2|expm1|log|log2|log10|log1p|cbrt|tgamma|lgamma|erfc?|fma)f?l?\()");
  const std::regex by_eigen(
      R"(AngleAxis|eulerAngles|slerp|angularDistance|Rotation2D|computeDirect|stableNorm|hypotNorm)");
  std::size_t sources = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(THIMBLE_SOURCE_DIR) / "host-tools/compiler")) {
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
    if (entry.path().stem() == "portable_math") continue;
    ++sources;
    std::ifstream in(entry.path());
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      line = line.substr(0, line.find("//"));
      for (std::size_t at = 0; (at = line.find('"', at)) != std::string::npos;) {  // strings
        const std::size_t end = std::min(line.find('"', at + 1), line.size() - 1);
        line.erase(at, end + 1 - at);
      }
      EXPECT_FALSE(std::regex_search(line, inexact) || std::regex_search(line, by_eigen))
          << entry.path().string() << ":" << number << ": " << line;
    }
  }
  EXPECT_GT(sources, 60U);
}

}  // namespace
}  // namespace thimble::test
