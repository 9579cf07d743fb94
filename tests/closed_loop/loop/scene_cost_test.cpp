// The estimate of what a scene costs on a board. Its figures are compared with exact counts by cortex.replay.*.
#include "board/sim/scene_cost.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "firmware/core/config.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::SceneCost;

const board::BoardCost& m7() { return *board::find_board_cost("mps2-an500"); }

std::vector<std::byte> demonstration(const std::string& file) {
  return host::compile_scene(std::filesystem::path(THIMBLE_SOURCE_DIR) / "scenes" / file).image;
}

TEST(SceneCost, IsTheSameEveryTimeAndMoreForTwoArms) {
  const auto image = demonstration("walls/walls.scene.json");
  const auto one = board::scene_cost(image, m7(), 4000, 300);
  const auto again = board::scene_cost(image, m7(), 4000, 300);
  const auto two = board::scene_cost(image, m7(), 4000, 300, 2);
  ASSERT_TRUE(one && again && two);
  EXPECT_EQ(one->typical.instructions, again->typical.instructions);
  EXPECT_EQ(one->worst.instructions, again->worst.instructions);
  EXPECT_GT(two->typical.instructions, one->typical.instructions + 2000);
  EXPECT_TRUE(one->fits());
  EXPECT_EQ(one->period, 120'000);
}

TEST(SceneCost, FewerUnitsPutMoreOffAndTheFittingRateIsTheHighest) {
  const auto image = demonstration("multy3/multy3.scene.json");
  const auto many = board::scene_cost(image, m7(), 4000, 4000);
  const auto few = board::scene_cost(image, m7(), 10000, m7().work_units(10000));
  ASSERT_TRUE(many && few);
  EXPECT_EQ(many->put_off, 0.0);
  EXPECT_GT(few->put_off, 0.5);
  EXPECT_TRUE(few->slow_object);
  const auto fits_Hz = board::highest_fitting_rate_Hz(image, m7(), 10000);
  ASSERT_TRUE(fits_Hz);
  const auto fits = [&](double rate_Hz) {
    return board::scene_cost(image, m7(), rate_Hz, m7().work_units(rate_Hz))->fits();
  };
  EXPECT_TRUE(fits(*fits_Hz));
  EXPECT_FALSE(fits(*fits_Hz + board::kRateStep_Hz));
}

TEST(SceneCost, AtEachRateTheUnitsAreEnoughForEachArm) {
  for (const double rate_Hz : {1000.0, 4000.0, 12000.0, 12500.0, 20000.0})
    for (const std::size_t arms : {1U, 2U})
      EXPECT_GE(m7().work_units(rate_Hz, arms), firmware::kLeastWork * arms) << rate_Hz;
}

TEST(SceneCost, ATouchIsFoundWhereverTheObjectIsInReach) {
  const auto with_contacts = [](std::size_t contacts) {
    return m7().of(board::terms_of({}, 1.0F / 4000.0F, 1, contacts, contacts));
  };
  const double touch = with_contacts(1) - with_contacts(0);
  EXPECT_GT(touch, 100.0);
  for (const double x_m : {-0.12, 0.0, 0.12}) {
    const SceneImage image = SceneBuilder().sphere(0.02, {}, {.position_m = {x_m, 0.0, -0.05}}).image();
    const SceneCost cost = *board::scene_cost(image.bytes(), m7(), 4000, 300);
    const SceneCost beyond = *board::scene_cost(
        SceneBuilder().sphere(0.02, {}, {.position_m = {2.0, 0.0, 0.0}}).image().bytes(), m7(), 4000, 300);
    EXPECT_GT(cost.typical.instructions, beyond.typical.instructions + 0.9 * touch) << x_m;
  }
}

TEST(SceneCost, NothingIsToldOfBytesThatAreNoScene) {
  EXPECT_FALSE(board::scene_cost({}, m7(), 4000, 300));
  EXPECT_FALSE(board::scene_cost(std::vector<std::byte>(100), m7(), 4000, 300));
  EXPECT_FALSE(board::highest_fitting_rate_Hz({}, m7(), 4000));
}

}  // namespace
}  // namespace thimble::test
