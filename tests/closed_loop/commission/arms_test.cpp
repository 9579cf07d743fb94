// Families of arms beyond those of faults_test.cpp: closed loops, an axis that slides, links of unknown weight, and an arm with too much friction. Sound
// ones pass, and what is wrong is named by the step that can see it.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/commission/balance.h"
#include "host-tools/commission/sim_bench.h"
#include "host-tools/commission/steps.h"

namespace thimble::host {
namespace {

using enum ArmFault;
using Json = nlohmann::ordered_json;

Json json_of_arm(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / (name + ".arm.json"));
  return Json::parse(in);
}

ArmFile arm_from(const Json& json) { return read_arm_file(json.dump(), json.at("name").get<std::string>()); }

constexpr double kBelt = 15, kScrew = 30;  // turns of the motor for a metre

// A motor on a rail, with the friction of a cart in N.
Json rail_json(double turns_m) {
  Json arm = json_of_arm("arms/paddle");
  arm["name"] = "rail";
  arm["kinematics"]["serial"]["joints"][0]["type"] = "prismatic";
  arm["kinematics"]["serial"]["joints"][0]["axis"] = {1, 0, 0};
  Json& axis = arm["axes"][0];
  axis.erase("lower_deg");
  axis.erase("upper_deg");
  for (const char* part : {"encoder", "drive"}) axis[part]["turns_per_turn"] = turns_m;
  axis["lower_m"] = -.05;
  axis["upper_m"] = .05;
  axis["friction"] = {{"coulomb_N_m", .1}, {"viscous_N_m_s_rad", .5}};
  return arm;
}
ArmFile rail(double turns_m) { return arm_from(rail_json(turns_m)); }

// Up to `last`, or to the first step that does not pass.
struct Walk {
  int number = -1;
  StepResult result;
  double force_N = 0, speed_m_s = 0;  // before step 7
  bool closed = false;
};
Walk commission_to(const ArmFile& arm, std::vector<SimFault> faults, int last, std::uint64_t seed = 1) {
  SimBench bench(arm, std::move(faults), {.seed = seed});
  const Expectation expected(arm);
  Known known;
  StepContext context{bench, expected, known};
  Walk run;
  for (const Step& step : steps()) {
    if (step.number > last) break;
    if (step.number == 3) continue;  // the marks: as those of step 2
    run.number = step.number;
    run.result = step.run(context);
    if (step.number < 7) {
      run.force_N = bench.most_tip_force_N();
      run.speed_m_s = bench.most_tip_speed_m_s();
    }
    if (!run.result.passed) break;
  }
  run.closed = bench.plant().closed();
  return run;
}

bool is_long() { return std::getenv("THIMBLE_COMMISSION_ARMS") != nullptr; }

void expect_sound(const ArmFile& arm, int last) {
  const Walk run = commission_to(arm, {}, last);
  std::string found;
  for (const ArmFinding& one : run.result.findings) found += one.text + "\n";
  EXPECT_TRUE(run.result.passed) << arm.name << ": step " << run.number << ": " << found;
  EXPECT_EQ(run.number, last) << arm.name;
  EXPECT_TRUE(run.closed) << arm.name << ": its links parted";
  EXPECT_LT(run.force_N, 1) << arm.name;
  EXPECT_LT(run.speed_m_s, .1) << arm.name;
}

TEST(Arms, SoundOnesPass) {
  expect_sound(arm_from(json_of_arm("arms/pantograph")), is_long() ? 10 : 7);
  expect_sound(rail(kBelt), is_long() ? 10 : 8);
  expect_sound(rail(kScrew), is_long() ? 10 : 5);
  expect_sound(arm_from(json_of_arm("arms/touch")), is_long() ? 10 : 5);
  if (!is_long()) return;
  for (const char* name : {"arms/falcon", "docs/examples/five-bar/five-bar-odrive"})
    expect_sound(arm_from(json_of_arm(name)), 10);
}

void expect_named(const ArmFile& arm, const SimFault& fault, int step) {
  const Walk run = commission_to(arm, {fault}, step);
  EXPECT_EQ(run.number, step) << arm.name << " " << text_of(fault.fault).name;
  ASSERT_FALSE(run.result.findings.empty()) << arm.name << " " << text_of(fault.fault).name;
  const ArmFinding& found = run.result.findings.front();
  for (const ArmFinding& one : run.result.findings) EXPECT_EQ(one.fault, fault.fault) << one.text;
  EXPECT_TRUE(found.axis == static_cast<int>(fault.axis) || found.axis == static_cast<int>(fault.other))
      << found.text;
  EXPECT_LT(run.force_N, 1) << arm.name;
  EXPECT_LT(run.speed_m_s, .1) << arm.name;
}

TEST(Arms, FaultsOfAFiveBarAndOfARailAreNamed) {
  const ArmFile bars = arm_from(json_of_arm("docs/examples/five-bar/five-bar-odrive")), cart = rail(kBelt);
  expect_named(bars, {kMotorSign, 1, 1}, 5);
  expect_named(bars, {kMotorsSwapped, 0, 1}, 5);
  expect_named(bars, {kEncodersSwapped, 0, 1}, 2);
  expect_named(cart, {kMotorSign}, 5);
  expect_named(cart, {kDeadPhase}, 5);
  expect_named(cart, {kEncoderSign}, 2);
  expect_named(cart, {kSlip, 0, 0, 2}, 2);
}

// A pulse has too few counts to tell an acceleration: the way that it moves is known all the same.
TEST(Arms, ACoarseEncoderShowsAMotorThatTurnsBackwards) {
  for (const auto& [counts, coulomb] : {std::pair{100, .025}, std::pair{400, .028}}) {
    Json paddle = json_of_arm("arms/paddle");
    paddle["axes"][0]["encoder"]["counts_per_turn"] = counts;
    paddle["axes"][0]["friction"]["coulomb_N_m"] = coulomb;
    expect_sound(arm_from(paddle), 5);
    const Walk run = commission_to(arm_from(paddle), {}, 5);
    for (const Measure& measure : run.result.measures)
      EXPECT_TRUE(std::isfinite(measure.value)) << measure.name;
    expect_named(arm_from(paddle), {kMotorSign}, 5);
  }
}

// Its weight turns it more than its friction holds: what it does after a pulse says nothing of its motor.
TEST(Arms, AJointThatFallsEverywhereIsToldSo) {
  Json lift = rail_json(kBelt);
  lift["name"] = "lift";
  lift["kinematics"]["serial"]["joints"][0]["axis"] = {0, 0, 1};
  Json lever = json_of_arm("arms/paddle");
  lever["name"] = "lever";
  lever["kinematics"]["serial"]["joints"][0]["axis"] = {0, 1, 0};
  lever["kinematics"]["serial"]["tip_m"] = {.1, 0, 0};
  for (Json arm : {lift, lever}) {
    const std::string link = arm["kinematics"]["serial"]["joints"][0]["name"];
    const ArmFile unknown = arm_from(arm);
    arm["bodies"] = Json::array({{{"link", link}, {"mass_kg", .3}, {"centre_m", {.05, 0, 0}}}});
    const ArmFile known = arm_from(arm);
    for (const ArmFile* file : {&known, &unknown}) {
      SimBench bench(known, {}, {.seed = 3});
      const Expectation expected(*file);
      Known seen;
      StepContext context{bench, expected, seen};
      ASSERT_TRUE(prove_encoders(context).passed);
      const StepResult result = prove_currents(context);
      ASSERT_EQ(result.findings.size(), 1U) << file->name << (file == &known ? "" : " of unknown weight");
      EXPECT_EQ(result.findings[0].fault, kNoRest) << result.findings[0].text;
      EXPECT_TRUE(result.findings[0].corrections.empty());
      EXPECT_FALSE(result.passed);
    }
  }
}

// Less inertia than the other links leave, or than a rotor alone, would have no motion.
TEST(Arms, ALinkIsNeverLighterThanNothing) {
  int built = 0;
  for (const char* name : {"arms/paddle", "arms/pantograph", "arms/falcon"}) {
    const ArmFile arm = arm_from(json_of_arm(name));
    for (const double factor : {.3, .5, .8}) {
      try {
        const SimBench bench(arm, {{kWrongInertia, arm.axes.size() - 1, 0, factor}}, {});
        board::AnyPlant plant(bench.truth());
        ++built;
        EXPECT_GT(plant.mass_matrix().ldlt().vectorD().minCoeff(), 0) << name << " " << factor;
      } catch (const Error& error) {
        EXPECT_EQ(error.name, "bad-fault") << name << " " << factor;
      }
    }
  }
  EXPECT_GE(built, 2) << "a paddle has no other link";
}

// What slips seems to have another ratio, too, and its correction would be wrong once it is repaired.
TEST(Arms, ASlipIsNoRatioAndATenthOfATorqueIsSome) {
  expect_named(arm_from(json_of_arm("arms/wooden")), {kSlip, 0, 0, 1}, 2);
  expect_named(arm_from(json_of_arm("arms/wooden")), {kWeakMotor, 0, 0, .1}, 4);
  expect_named(arm_from(json_of_arm("arms/paddle")), {kWeakMotor, 0, 0, .1}, 4);
}

// The file of this arm says 0.1 N m of friction, too: more than 1 N at the tip, whichever joint the drive turns in truth.
TEST(Arms, OneWithTooMuchFrictionIsToldSo) {
  Json paddle = json_of_arm("arms/paddle");
  paddle["axes"][0]["friction"]["coulomb_N_m"] = .15;
  const ArmFile stiff = is_long() ? arm_from(json_of_arm("arms/chain-7")) : arm_from(paddle);
  const Walk run = commission_to(stiff, {}, 10);
  EXPECT_EQ(run.number, 5);
  ASSERT_EQ(run.result.findings.size(), stiff.axes.size());
  for (const ArmFinding& found : run.result.findings) {
    EXPECT_EQ(found.fault, kNoMotion);
    EXPECT_NE(found.text.find("No more is allowed"), std::string::npos) << found.text;
  }
  EXPECT_LT(run.force_N, 1);
}

// The file does not have the weights that the arm has: the place is found by letting the axis go.
TEST(Arms, AnAxisOfUnknownWeightRestsWhereItIsFound) {
  const ArmFile heavy = arm_from(json_of_arm("arms/premium-1.5"));
  Json light = json_of_arm("arms/premium-1.5");
  ASSERT_TRUE(light["kinematics"]["two_link"].contains("inertia"));
  light["kinematics"]["two_link"].erase("inertia");
  const ArmFile unknown = arm_from(light);
  const Expectation expected(unknown), truth(heavy);
  SimBench bench(heavy, {}, {.seed = 4});
  Known known;
  StepContext context{bench, expected, known};
  ASSERT_FALSE(expected.knows_inertia());
  ASSERT_TRUE(prove_encoders(context).passed);
  for (const std::size_t axis : {1U, 2U}) {
    const board::JointVector at = resting_place(context, axis);
    ASSERT_EQ(place(context, axis, at), Answer::kDone);
    const auto row = static_cast<Eigen::Index>(axis);
    EXPECT_NEAR(bench.plant().joints_rad()[row], at[row], .05) << "it fell";
    EXPECT_LT(std::abs(truth.weight(at)[row]), 1.5 * heavy.axes[axis].friction.coulomb_N_m.value);
  }
}

TEST(Arms, PlugsThatGoRoundAreOneFinding) {
  const ArmFile arm = arm_from(json_of_arm("arms/premium-1.5"));
  const Walk run = commission_to(arm, {{kEncodersSwapped, 0, 1}, {kEncodersSwapped, 1, 2}}, 2);
  ASSERT_EQ(run.number, 2);
  ASSERT_EQ(run.result.findings.size(), 1U) << run.result.findings[0].text;
  const ArmFinding& found = run.result.findings[0];
  EXPECT_EQ(found.fault, kEncodersSwapped);
  ASSERT_EQ(found.corrections.size(), 3U);
  Json corrected = json_of_arm("arms/premium-1.5");
  for (const Correction& correction : found.corrections)
    corrected[Json::json_pointer(correction.pointer)] = static_cast<int>(correction.value);
  SimBench bench(arm, {{kEncodersSwapped, 0, 1}, {kEncodersSwapped, 1, 2}}, {});
  const ArmFile right = arm_from(corrected);
  bench.use(right);
  const Expectation expected(right);
  Known known;
  StepContext context{bench, expected, known};
  const StepResult again = prove_encoders(context);
  EXPECT_TRUE(again.passed) << again.findings[0].text;
}

}  // namespace
}  // namespace thimble::host
