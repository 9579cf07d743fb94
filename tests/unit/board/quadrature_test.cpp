// Quadrature: the decoder against a wheel that is turned at random; every single lost edge is detected.
#include "board/common/quadrature.h"

#include <gtest/gtest.h>

#include <vector>

namespace thimble::test {
namespace {

using board::Quadrature;
using board::QuadratureLine;

struct Edge {
  QuadratureLine line;
  bool level;
};

// A wheel at a whole number of counts: A leads B by a quarter of a cycle.
class Wheel {
 public:
  static bool a(std::int64_t count) { return (count & 3) == 1 || (count & 3) == 2; }
  static bool b(std::int64_t count) { return (count & 3) == 2 || (count & 3) == 3; }
  Edge step(int direction) {
    const std::int64_t before = count_;
    count_ += direction;
    return a(before) != a(count_) ? Edge{QuadratureLine::kA, a(count_)} : Edge{QuadratureLine::kB, b(count_)};
  }
  std::int64_t count() const { return count_; }

 private:
  std::int64_t count_ = 0;
};

std::uint32_t next(std::uint32_t& state) { return state = state * 1664525U + 1013904223U; }

TEST(Quadrature, FollowsAWheel) {
  Wheel wheel;
  Quadrature decoder;
  decoder.reset(Wheel::a(0), Wheel::b(0));
  std::uint32_t random = 1;
  int turns = 0;
  for (int i = 0; i < 100'000; ++i) {
    const int direction = next(random) >> 31U != 0 ? 1 : -1;
    const unsigned steps = next(random) >> 28U;
    for (unsigned step = 0; step < steps; ++step) {
      const Edge edge = wheel.step(direction);
      decoder.edge(edge.line, edge.level);
    }
    turns += direction;
    ASSERT_EQ(decoder.count(), static_cast<std::uint32_t>(wheel.count()));  // below zero it wraps
    ASSERT_FALSE(decoder.lost());
  }
  EXPECT_NE(turns, 0);
}

// Whatever edge is lost: the next one of that line tells, within a cycle of turning.
TEST(Quadrature, NoticesEachLostEdge) {
  for (const int direction : {1, -1}) {
    for (int lost = 0; lost < 8; ++lost) {
      Wheel wheel;
      Quadrature decoder;
      decoder.reset(Wheel::a(0), Wheel::b(0));
      for (int i = 0; i < lost + 5; ++i) {
        const Edge edge = wheel.step(direction);
        if (i != lost) decoder.edge(edge.line, edge.level);
        if (i < lost) {
          EXPECT_FALSE(decoder.lost());
        }
      }
      EXPECT_TRUE(decoder.lost()) << "edge " << lost << ", direction " << direction;
      decoder.reset(Wheel::a(wheel.count()), Wheel::b(wheel.count()));
      EXPECT_FALSE(decoder.lost());
    }
  }
}

}  // namespace
}  // namespace thimble::test
