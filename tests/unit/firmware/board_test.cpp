// What a board tells the controller about itself: what it lacks, and that it wants pauses.
#include <gtest/gtest.h>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

TEST(Board, ThatLacksSomethingIsNotArmedButAnswers) {
  Bench bench({.lacks = "no_realtime_priority"});
  bench.load();
  bench.home();
  EXPECT_EQ(bench.controller->request(Command::kArm), firmware::kBoardLacks);
  EXPECT_EQ(bench.mode(), Mode::kReady);
}

// Checking a large image pauses often enough for a tick of 250 us on a slow board: every 64 elements or kilobyte.
int pauses = 0;
TEST(Board, LongWorkPauses) {
  pauses = 0;
  const std::vector<std::byte> image = plane_image(300.0F, 0.0F, 0.0F, std::string(20'000, 'x'));
  Bench bench({.pause = []() noexcept { ++pauses; }}, 65536);
  ASSERT_EQ(bench.controller->load_scene(image), firmware::StoreStatus::kOk);
  EXPECT_GE(pauses, static_cast<int>(image.size() / 1024));
}

}  // namespace
}  // namespace thimble::test
