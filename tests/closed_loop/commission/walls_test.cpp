// Step 10: walls that rise in stiffness until one swings, against what wall_limit.h computes for the same arm; and how hard and fast that is.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "host-tools/arms/arm_data.h"
#include "host-tools/commission/sim_bench.h"
#include "host-tools/commission/steps.h"
#include "host-tools/commission/wall_limit.h"
#include "tests/support/figure.h"

namespace thimble::host {
namespace {

ArmFile arm_with_walls(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

struct Pressed {
  StepResult result;
  double force_N = 0;  // the largest of the motors at the tip
};

Pressed press_walls(const ArmFile& arm, double drive_delay_s) {
  SimBench bench(arm, {}, {.seed = 2, .spread = 0, .drive_delay_s = drive_delay_s});
  const Expectation expected(arm);
  Known known;
  StepContext context{bench, expected, known};
  EXPECT_TRUE(prove_encoders(context).passed);
  EXPECT_EQ(bench.most_tip_force_N(), 0) << "nothing was driven yet";
  Pressed pressed{find_walls(context)};
  pressed.force_N = bench.most_tip_force_N();
  return pressed;
}

// Also with a drive that is late: such a loop holds softer walls only.
TEST(Walls, AreThoseThatAreComputedForTheArm) {
  // Other arms and dampings take longer: only with THIMBLE_COMMISSION_ARMS.
  const bool whole = std::getenv("THIMBLE_COMMISSION_ARMS") != nullptr;
  std::vector<const char*> names{"paddle"};
  if (whole) names = {"paddle", "premium-1.5", "wooden"};
  for (const char* name : names) {
    const ArmFile arm = arm_with_walls(name);
    const Pressed at_once = press_walls(arm, 0);
    ASSERT_TRUE(at_once.result.passed);
    ASSERT_EQ(at_once.result.measures.size(), 3U);
    const board::AnyPlantParameters plant =
        board::AnyPlantParameters::from(arm_data(arm), arm.body_inertia_kg_m2);
    for (std::size_t i = 0; i < 3; ++i) {
      const Measure& wall = at_once.result.measures[i];
      if (!whole && i != 1) continue;
      const double computed = largest_wall_N_m(
          arm, plant,
          {.rate_Hz = wall.rate_Hz, .damping_N_s_m = wall.damping_N_s_m, .hold_s = 1.5, .by_counts = true});
      test::figure(std::string(name) + " with B = " + std::to_string(i) + " N s/m, N/m: pressed", wall.value,
                   "");
      test::figure("  computed", computed, "15 %");
      EXPECT_EQ(wall.damping_N_s_m, static_cast<double>(i));
      EXPECT_NEAR(wall.value / computed, 1, .15) << name << " B " << wall.damping_N_s_m;
    }
    test::figure(std::string(name) + ": largest force of the motors at the tip, N", at_once.force_N, "5");
    EXPECT_LT(at_once.force_N, 5) << "4 N of the wall, and the weight";
    EXPECT_GT(at_once.force_N, 1.5) << "nobody pressed";
    if (std::string(name) != "paddle") continue;
    const Pressed late = press_walls(arm, 4.0 / 4000);
    test::figure("  with a drive that is four ticks late, B = 1 N s/m", late.result.measures.at(1).value,
                 "half of it at most");
    EXPECT_LT(late.result.measures.at(1).value, .5 * at_once.result.measures[1].value);
    EXPECT_GT(late.result.measures.at(1).value, 0);
  }
}

}  // namespace
}  // namespace thimble::host
