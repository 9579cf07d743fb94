// Hours of play without a fault of the controller's own. THIMBLE_ENDURANCE_S: simulated seconds of each of the two hands;
// THIMBLE_ENDURANCE_SEED.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdlib>
#include <string>

#include "tests/closed_loop/endurance/play.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtod(text, nullptr) : otherwise;
}

void endures(std::uint64_t seed) {
  const double seconds = from_environment("THIMBLE_ENDURANCE_S", 900);
  (void)play(seed, seconds / 20);
  const std::size_t before = mallinfo2().uordblks;
  const Played played =
      play(seed + static_cast<std::uint64_t>(from_environment("THIMBLE_ENDURANCE_SEED", 0)) * 100, seconds);
  const auto after = static_cast<double>(mallinfo2().uordblks);
  for (const std::string& complaint : played.complaints) ADD_FAILURE() << complaint;
  figure("simulated, h", played.simulated_s / 3600, ">= asked for");
  figure("of it armed, h", played.armed_s / 3600, "reported");
  figure("starts of a board; armings", played.boards, "reported");
  figure("armings", played.arms_armed, "reported");
  figure("scenes exchanged", played.swaps, "reported");
  figure("uploads over the link", played.uploads, "reported");
  figure("parameters written", played.writes, "reported");
  figure("stops", played.stops, "reported");
  figure("commands of a second host while the arm was armed", played.rivals, "none obeyed");
  figure("faults of the hardware", played.injected, "reported");
  std::uint32_t named = 0;
  for (const std::uint32_t count : played.named) named += count;
  figure("faults named", named, "reported");
  figure("false faults", static_cast<double>(played.complaints.size()), "0");
  figure("growth of the heap, kB", (after - static_cast<double>(before)) / 1024, "<= 64");
  EXPECT_GE(played.simulated_s, seconds);
  EXPECT_LE(after, static_cast<double>(before) + 65536);
}

TEST(Endurance, OneHandPlaysOnAndOn) { endures(1); }
TEST(Endurance, AnotherHandPlaysOnAndOn) { endures(2); }

}  // namespace
}  // namespace thimble::test
