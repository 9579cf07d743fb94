// The C++ listing of docs/overview.md is compiled as printed, and renders a wall.
#include <gtest/gtest.h>

#include "overview_listing.h"  // NOLINT(misc-include-cleaner): generated from docs/overview.md
#include "tests/support/scene.h"

namespace {

TEST(Overview, TheListingRendersAWall) {
  constexpr float kStiffness_N_m = 500, kDepth_m = 0.002F, kPeriod_s = 1.0F / 4000.0F;
  EXPECT_FALSE(start({}));

  thimble::test::SceneBuilder wall;
  wall.plane({0, 0, 1}, 0, {.stiffness_N_m = kStiffness_N_m});
  const auto image = wall.bytes();
  ASSERT_TRUE(start(image));
  Tip tip;
  Touch touch;
  tip.position_m = {0, 0, 0.001F};
  tick(std::span(&tip, 1), kPeriod_s, std::span(&touch, 1));
  EXPECT_EQ(touch.force_N.norm(), 0);
  tip.position_m = {0, 0, -kDepth_m};
  tick(std::span(&tip, 1), kPeriod_s, std::span(&touch, 1));
  EXPECT_NEAR(touch.force_N.z(), kStiffness_N_m * kDepth_m, 1e-4F);
}

}  // namespace
