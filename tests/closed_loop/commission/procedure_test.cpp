// A commissioning from the arm file to the new one: corrected, interrupted, resumed.
#include "host-tools/commission/procedure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/commission/sim_bench.h"

namespace thimble::host {
namespace {

std::string text_of_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string arm_text(const std::string& name) {
  return text_of_file(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
}

TEST(Procedure, CorrectsTheFileAndGoesOnWhereItWas) {
  const std::string text = arm_text("paddle");
  SimBench bench(read_arm_file(text, "paddle"),
                 {{ArmFault::kMotorSign, 0, 0, 1}, {ArmFault::kWrongCounts, 0, 0, 4}},
                 {.seed = 2, .accepts_corrections = true});
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "commission.json";
  Commission(text, "paddle", "commission test").save(file);
  int steps_done = 0;
  for (;;) {
    // Each step in a program of its own.
    Commission commission = Commission::from_state(text_of_file(file));
    const int number = commission.next();
    if (number > 9) break;
    ASSERT_LT(++steps_done, 14) << commission.report();
    static_cast<void>(commission.run(number, bench));
    commission.save(file);
  }
  EXPECT_EQ(steps_done, 12) << "ten steps, and two of them again after a correction";
  const Commission commission = Commission::from_state(text_of_file(file));
  const ArmFile arm = read_arm_file(commission.arm_file(""), "result");
  EXPECT_EQ(arm.axes[0].encoder.counts_per_turn.value, 8192);
  EXPECT_EQ(arm.axes[0].drive->sign, -1);
  EXPECT_EQ(arm.axes[0].friction.coulomb_N_m.by, "commission test");
  const board::AxisTruth& truth = bench.truth().axis[0];
  EXPECT_NEAR(arm.axes[0].friction.coulomb_N_m.value, truth.coulomb_N_m, .2 * truth.coulomb_N_m);
  EXPECT_GT(arm.axes[0].friction.coulomb_N_m.spread, 0);
  ASSERT_TRUE(arm.axes[0].stiffness_N_m_rad);
  EXPECT_NEAR(arm.axes[0].stiffness_N_m_rad->value, truth.stiffness_N_m_rad, .1 * truth.stiffness_N_m_rad);
  const std::string report = commission.report();
  std::printf("%s", report.c_str());
  EXPECT_NE(report.find("coulomb_N_m"), std::string::npos);
  EXPECT_EQ(report.find("FAILED"), std::string::npos);
}

TEST(Procedure, RefusesAStepBeforeThoseThatItBuildsOn) {
  const std::string text = arm_text("paddle");
  SimBench bench(read_arm_file(text, "paddle"), {}, {});
  Commission commission(text, "paddle", "test");
  try {
    static_cast<void>(commission.run(5, bench));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.name, "step-order");
    EXPECT_EQ(error.remedy, "do step 0 first");
  }
}

TEST(Procedure, RefusesAStateThatIsNone) {
  for (const char* text :
       {"", "{}", R"({"thimble_commission": 2})", R"({"thimble_commission": 1, "name": 3})"}) {
    try {
      static_cast<void>(Commission::from_state(text));
      FAIL() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.name, "bad-state") << text;
    }
  }
}

}  // namespace
}  // namespace thimble::host
