// A commissioning from the arm file to the new one: corrected, interrupted, resumed.
#include "host-tools/commission/procedure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
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

// What step 4 measured of a motor was of another joint's.
TEST(Procedure, AfterExchangedMotorsTheirCurrentsComeAgain) {
  const std::string text = arm_text("premium-1.5");
  SimBench bench(read_arm_file(text, "premium-1.5"), {{ArmFault::kMotorsSwapped, 1, 2, 1}},
                 {.accepts_corrections = true});
  Commission commission(text, "premium-1.5", "test");
  while (commission.next() < 5) ASSERT_TRUE(commission.run(commission.next(), bench).passed);
  EXPECT_FALSE(commission.run(5, bench).passed);
  EXPECT_EQ(commission.next(), 4);
  EXPECT_EQ(commission.results().count(4), 0U);
  ASSERT_TRUE(commission.run(4, bench).passed);
  EXPECT_TRUE(commission.run(5, bench).passed) << "with the ports exchanged in the file";
}

// A viscous friction that is too small to be measured: the file that had no friction gets what was seen, and can be read.
TEST(Procedure, AFileWithoutFrictionGetsAllOfItOrNone) {
  nlohmann::json arm = nlohmann::json::parse(arm_text("paddle"));
  arm["axes"][0].erase("friction");
  const Commission empty(arm.dump(), "paddle", "test");
  nlohmann::json state = nlohmann::json::parse(empty.state());
  const auto measure = [](const char* name, double value, double spread, double promise) {
    return nlohmann::json{{"name", name},       {"axis", 0},          {"given", nullptr},
                          {"value", value},     {"spread", spread},   {"residual", 0.0},
                          {"promise", promise}, {"rate_Hz", nullptr}, {"damping_N_s_m", nullptr}};
  };
  const auto with = [&](double coulomb_spread) {
    state["steps"]["9"] = {
        {"passed", true},
        {"stopped", false},
        {"findings", nlohmann::json::array()},
        {"notes", nlohmann::json::array()},
        {"measures",
         {measure("coulomb_N_m", .004, coulomb_spread, .2), measure("viscous_N_m_s_rad", -3e-6, 6e-6, .3)}}};
    return read_arm_file(Commission::from_state(state.dump()).arm_file(""), "result");
  };
  const ArmFile seen = with(1e-4);
  EXPECT_EQ(seen.axes[0].friction.coulomb_N_m.value, .004);
  EXPECT_EQ(seen.axes[0].friction.viscous_N_m_s_rad.value, 0);
  EXPECT_EQ(seen.axes[0].friction.viscous_N_m_s_rad.spread, 6e-6);
  EXPECT_EQ(with(.01).axes[0].friction.coulomb_N_m.value, 0) << "too uncertain";
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
