// What `thimble-board --measure` proposes, with clocks whose time is known.
#include "board/linux/measure_work.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "firmware/core/config.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

std::uint64_t real_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

std::vector<std::byte> ring() {
  return host::compile_scene(std::filesystem::path(THIMBLE_SOURCE_DIR) / "scenes/ring/ring.scene.json").image;
}

// Each tick takes 5 us, and each fourth reading of the clock comes 1 ms late: the machine does something else.
TEST(MeasureWork, WhatInterruptsTheProgramDoesNotCount) {
  std::uint64_t now_ns = 0, calls = 0;
  const auto clock = [&] {
    now_ns += ++calls % 2 == 0 ? 5000U : 700U;
    if (calls % 7 == 4) now_ns += 1'000'000;
    return now_ns;
  };
  const auto found = board::measure_work(ring(), 4000, 1000, 1, clock);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->worst_tick_ns, 5000.0);
  EXPECT_GE(found->most_units, board::kTellingUnits);
  EXPECT_LE(found->most_units, 1000U);
  EXPECT_GE(found->unit_ns, 5000.0 / found->most_units);
  EXPECT_LE(found->unit_ns, 2 * 5000.0 / found->most_units);
}

TEST(MeasureWork, AProposalIsAQuarterOfThePeriodAndEnoughForEachArm) {
  EXPECT_EQ(board::proposed_work_units(250.0, 1000.0, 1), 1000U);
  EXPECT_EQ(board::proposed_work_units(250.0, 4000.0, 1), 250U);
  EXPECT_EQ(board::proposed_work_units(2500.0, 4000.0, 2), 2 * firmware::kLeastWork);
  EXPECT_LE(board::proposed_work_units(0.0, 400.0, 1), 1'000'000U);
}

// By a real clock, whose times a test cannot require.
TEST(MeasureWork, NoTickExceedsTheUnitsThatItProposes) {
  const auto image = ring();
  const auto found = board::measure_work(image, 20'000, 4000, 2, real_ns);
  ASSERT_TRUE(found);
  EXPECT_GT(found->unit_ns, 0.0);
  const std::uint32_t units = board::proposed_work_units(found->unit_ns, 20'000, 2);
  const auto then = board::measure_work(image, 20'000, units, 2, real_ns);
  ASSERT_TRUE(then);
  EXPECT_LE(then->most_units, units);
}

TEST(MeasureWork, NothingIsMeasuredWithoutAScene) {
  EXPECT_FALSE(board::measure_work({}, 4000, 1000, 1, real_ns));
  EXPECT_FALSE(board::measure_work(std::vector<std::byte>(100), 4000, 1000, 1, real_ns));
}

}  // namespace
}  // namespace thimble::test
