// The commissioning of a simulated arm whose motors obey a whole controller, over the link: sound arms pass, what is measured is true, and what is wrong is
// named by the step that can see it. With THIMBLE_COMMISSION_ARMS more arms go to the end.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/commission/link_bench.h"
#include "host-tools/commission/planted.h"
#include "host-tools/commission/procedure.h"
#include "host-tools/commission/wall_loop.h"
#include "tests/closed_loop/commission/linked_bench.h"

namespace thimble::test {
namespace {

using host::ArmFault;

std::string text_of(const std::string& file) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / (file + ".arm.json"));
  return {std::istreambuf_iterator<char>(in), {}};
}

const std::string kFiveBar = "docs/examples/five-bar/five-bar-odrive";

bool is_long() { return std::getenv("THIMBLE_COMMISSION_ARMS") != nullptr; }

struct Rig {
  explicit Rig(const std::string& file, const std::vector<std::string>& faults = {},
               const host::SimBenchOptions& options = {})
      : text(text_of(file)),
        arm(host::read_arm_file(text, file)),
        bench(arm, planted(faults, arm), options),
        commission(text, file, "test") {}

  static std::vector<host::SimFault> planted(const std::vector<std::string>& faults,
                                             const host::ArmFile& arm) {
    std::vector<host::SimFault> all;
    all.reserve(faults.size());
    for (const std::string& fault : faults) all.push_back(host::planted_fault(fault, arm));
    return all;
  }

  // From the next step on, each with a connection of its own, as programs that go on. The first step that does not pass; last + 1: none.
  int go(int last) {
    while (commission.next() <= last) {
      const int step = commission.next();
      host::LinkBench link([this] { return bench.open(); }, bench, 0, commission.arm());
      link.begin_step(step);
      if (step == 7)
        before_strong_N = bench.most_tip_force_N(), before_strong_m_s = bench.most_tip_speed_m_s();
      const double began_s = bench.time_s();
      const host::StepResult& result = commission.run(step, link);
      std::printf("step %2d: %6.1f s, at most %.2f N and %.3f m/s\n", step, bench.time_s() - began_s,
                  bench.most_tip_force_N(), bench.most_tip_speed_m_s());
      for (const host::ArmFinding& found : result.findings) std::printf("  %s\n", found.text.c_str());
      if (!result.passed) return step;
    }
    return last + 1;
  }
  [[nodiscard]] std::vector<ArmFault> found(int step) const {
    std::vector<ArmFault> faults;
    for (const host::ArmFinding& finding : commission.results().at(step).findings)
      faults.push_back(finding.fault);
    return faults;
  }

  std::string text;
  host::ArmFile arm;
  LinkedBench bench;
  host::Commission commission;
  double before_strong_N = 0, before_strong_m_s = 0;
};

TEST(LinkCommission, APaddleIsMeasuredAsItIs) {
  Rig rig("arms/paddle", {}, {.seed = 3});
  ASSERT_EQ(rig.go(10), 11);
  EXPECT_LE(rig.before_strong_N, host::kTipForce_N);
  EXPECT_LE(rig.before_strong_m_s, host::kTipSpeed_m_s);
  const host::ArmFile measured = host::read_arm_file(rig.commission.arm_file("2026-12-01"), "result");
  const board::AxisTruth& truth = rig.bench.truth().axis[0];
  const host::ArmAxis& axis = measured.axes[0];
  EXPECT_EQ(axis.friction.coulomb_N_m.by, "test");
  EXPECT_NEAR(axis.friction.coulomb_N_m.value, truth.coulomb_N_m, .2 * truth.coulomb_N_m);
  ASSERT_TRUE(axis.stiffness_N_m_rad);
  EXPECT_NEAR(axis.stiffness_N_m_rad->value, truth.stiffness_N_m_rad, .1 * truth.stiffness_N_m_rad);
  EXPECT_EQ(measured.largest_walls.size(), 3U);
  EXPECT_TRUE(measured.is_commissioned);
  EXPECT_FALSE(host::read_arm_file(rig.commission.arm_file(""), "result").is_commissioned);
  const firmware::link::StatusFlags flags = rig.bench.open().state().flags;
  EXPECT_FALSE(flags.supervised) << "the parameters are given back";
}

TEST(LinkCommission, APremiumPasses) {
  Rig rig("arms/premium-1.5");
  const int last = is_long() ? 10 : 8;
  EXPECT_EQ(rig.go(last), last + 1);
  EXPECT_LE(rig.before_strong_N, host::kTipForce_N);
  EXPECT_LE(rig.before_strong_m_s, host::kTipSpeed_m_s);
}

TEST(LinkCommission, AFiveBarWithAMotorWiredBackwardsIsRepairedAndPasses) {
  Rig rig(kFiveBar);
  const std::string first = rig.arm.axes[0].name;
  Rig wrong(kFiveBar, {"motor-sign@" + first});
  ASSERT_EQ(wrong.go(10), 5);
  EXPECT_EQ(wrong.found(5), std::vector{ArmFault::kMotorSign});
  wrong.bench.mend(0);
  const int last = is_long() ? 10 : 7;
  EXPECT_EQ(wrong.go(last), last + 1);
  if (!is_long()) return;
  // Without the device's probes at rest all walls are still. A probe is no swing.
  for (const host::Measure& wall : wrong.commission.results().at(10).measures)
    EXPECT_GT(wall.value, 5e4) << "B = " << wall.damping_N_s_m;
}

TEST(LinkCommission, WhatIsWrongIsNamed) {
  const struct {
    const char *arm, *fault;
    int step;
    ArmFault named;
    bool measures_current = true;
  } kCases[] = {
      {"arms/paddle", "line-ignored", 0, ArmFault::kLineIgnored},
      {"arms/paddle", "encoder-sign@paddle", 2, ArmFault::kEncoderSign},
      {"arms/premium-1.5", "encoders-swapped@upper,fore", 2, ArmFault::kEncodersSwapped},
      {"arms/premium-1.5", "dead-encoder@fore", 2, ArmFault::kDeadEncoder},
      {"arms/premium-1.5", "motors-swapped@yaw,upper", 5, ArmFault::kMotorsSwapped},
      {"docs/examples/five-bar/five-bar-odrive", "open-winding@first", 4, ArmFault::kOpenWinding},
      {"arms/paddle", "open-winding@paddle", 5, ArmFault::kNoMotion, false},
  };
  for (const auto& c : kCases) {
    Rig rig(c.arm, {c.fault}, {.measures_current = c.measures_current});
    EXPECT_EQ(rig.go(8), c.step) << c.fault;
    const std::vector<ArmFault> found = rig.found(c.step);
    EXPECT_NE(std::find(found.begin(), found.end(), c.named), found.end()) << c.fault;
    EXPECT_LE(rig.bench.most_tip_force_N(), host::kTipForce_N) << c.fault;
    EXPECT_LE(rig.bench.most_tip_speed_m_s(), host::kTipSpeed_m_s) << c.fault;
  }
}

// The device counts from its mark, and step 3 says where that is: without it the mark is a fault (index_mismatch) wherever the stops are off by more
// than 0.01 rad.
TEST(LinkCommission, AMarkIsHomeFromStep3On) {
  const std::string text = text_of("arms/premium-1.5");
  const host::ArmFile arm = host::read_arm_file(text, "premium-1.5");
  const double turns = arm.axes[1].encoder.turns_per_turn.value;
  const auto measured = [](const Rig& rig, int axis) {
    for (const host::Measure& measure : rig.commission.results().at(3).measures)
      if (measure.name == "home_mark_rad" && measure.axis == axis) return measure;
    return host::Measure{};
  };
  {
    Rig rig("arms/premium-1.5");
    ASSERT_EQ(rig.go(3), 4);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(measured(rig, axis).value), .03) << axis;
      EXPECT_LE(measured(rig, axis).spread, .006 + 1e-3) << "as wide as the mark is";
    }
  }
  {
    Rig rig("arms/premium-1.5", {"index-off@" + arm.axes[1].name});
    ASSERT_EQ(rig.go(3), 3);
    ASSERT_EQ(rig.found(3), std::vector{ArmFault::kIndexOff});
    EXPECT_EQ(rig.commission.results().at(3).findings[0].axis, 1);
    EXPECT_NEAR(measured(rig, 1).value, 2 * std::numbers::pi / turns, .03);
  }
  {
    Rig rig("arms/premium-1.5");  // its stops are not where the file has them
    std::string turned = text;
    for (const auto& [given, other] : {std::pair{"\"lower_deg\": -90", "\"lower_deg\": -88"},
                                       std::pair{"\"upper_deg\": 90", "\"upper_deg\": 92"}})
      turned.replace(turned.find(given), std::strlen(given), other);
    rig.commission = host::Commission(turned, "premium-1.5", "test");
    EXPECT_EQ(rig.go(5), 6) << "a fault where the device's home is still that of the stops";
    EXPECT_NEAR(std::abs(measured(rig, 0).value), 2 * std::numbers::pi / 180, .005);
  }
  Rig rig("arms/premium-1.5", {}, {.has_mark = false});
  EXPECT_EQ(rig.go(3), 4);
  EXPECT_FALSE(rig.commission.results().at(3).notes.empty());
}

TEST(LinkCommission, ALostTickIsNoDeadEncoder) {
  Rig rig("arms/paddle");
  ASSERT_EQ(rig.go(1), 2);
  rig.bench.lose_a_tick_in(3);  // while the paddle is turned
  try {
    static_cast<void>(rig.go(2));
    FAIL();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "counts-missing");
    EXPECT_EQ(error.code, host::ExitCode::kLinkLost);
  }
  EXPECT_EQ(rig.go(2), 3) << "the step again";
}

TEST(LinkCommission, DrivesThatDoNotKnowTheirPositionsYetAreAwaited) {
  Rig rig("arms/paddle");
  rig.bench.know_encoders_in(3);
  EXPECT_EQ(rig.go(0), 1);
  EXPECT_GT(rig.bench.time_s(), 3);
}

// With another file the device starts anew.
TEST(LinkCommission, TheDevicesLimitOfForceHoldsAfterACorrection) {
  Rig rig("arms/paddle", {"motor-sign@paddle"}, {.accepts_corrections = true});
  const auto max_force_N = [&] {
    std::uint32_t bits = 0;
    EXPECT_EQ(rig.bench.controller().read_param(firmware::find_param("max_force")->id, bits),
              firmware::ParamStatus::kOk);
    return std::bit_cast<float>(bits);
  };
  ASSERT_EQ(rig.go(4), 5);
  const float before_N = max_force_N();
  {
    host::LinkBench link([&] { return rig.bench.open(); }, rig.bench, 0, rig.commission.arm());
    link.begin_step(5);
    EXPECT_FALSE(rig.commission.run(5, link).passed);
    ASSERT_EQ(rig.commission.corrections().size(), 1U);
    link.begin_step(5);
    EXPECT_TRUE(rig.commission.run(5, link).passed) << "with the file that was corrected";
    EXPECT_EQ(max_force_N(), 1.0F);
    EXPECT_LE(rig.bench.most_tip_force_N(), host::kTipForce_N);
  }
  EXPECT_EQ(max_force_N(), before_N);
}

TEST(LinkCommission, AWallThatMakesTheTipTooFastIsSwitchedOff) {
  Rig rig("arms/paddle");
  ASSERT_EQ(rig.go(2), 3);
  host::LinkBench link([&] { return rig.bench.open(); }, rig.bench, 0, rig.arm);
  link.begin_step(10);
  link.locate({});
  host::Prompt home = host::prompt(host::Prompt::Kind::kPlace, 1, "home");
  home.place.at(0) = rig.arm.axes[0].home.value;
  EXPECT_EQ(link.ask(home), host::Answer::kDone);
  host::TipProgram wall;
  wall.kind = host::TipProgram::Kind::kWall;
  wall.stiffness_N_m = 1e5;  // it swings
  wall.most_force_N = 4;
  wall.most_speed_m_s = .1;  // its least
  wall.wall_normal = host::wall_normal(host::Expectation(rig.arm));
  wall.wall_depth_m = .01;
  host::Prompt press = host::prompt(host::Prompt::Kind::kPressWall, 0, "press");
  press.direction = -wall.wall_normal;
  press.wall_N_m = wall.stiffness_N_m;
  press.wall_m = wall.wall_depth_m;
  press.press_N = host::press_N(wall);
  EXPECT_EQ(link.feel(wall, press).ending, host::Ending::kSpeed);
  EXPECT_EQ(rig.bench.open().state().fault, 0) << "the next wall is pressed without another command";
}

// A servo against a firm hand changes a joint's torque and moves nothing, which is what a dead encoder looks like (encoder_frozen).
TEST(LinkCommission, WhatTheHandsHoldIsNotDriven) {
  Rig rig(kFiveBar);
  ASSERT_EQ(rig.go(3), 4);
  host::LinkBench link([&] { return rig.bench.open(); }, rig.bench, 0, rig.arm);
  link.begin_step(9);
  link.locate({});
  host::Prompt place = host::prompt(host::Prompt::Kind::kPlace, 0, "home");
  for (std::size_t j = 0; j < rig.arm.axes.size(); ++j) place.place.at(j) = rig.arm.axes[j].home.value;
  host::AxisProgram tone;
  tone.seconds = .1;
  tone.tone_A = .5;
  tone.tone_Hz = 20;
  for (int k = 0; k < 8; ++k) {
    place.axis = static_cast<std::size_t>(k % 2);
    tone.axis = place.axis;
    EXPECT_EQ(link.ask(place), host::Answer::kDone);
    EXPECT_EQ(link.run(tone).ending, host::Ending::kTime) << k;
    EXPECT_GE(rig.bench.most_A(tone.axis), .49F);
    EXPECT_EQ(rig.bench.most_A(1 - tone.axis), 0) << k;
  }
}

TEST(LinkCommission, ARecordingOfAnotherProgramIsNotTaken) {
  Rig rig("arms/paddle");
  EXPECT_EQ(rig.go(0), 1);
  host::Device other = rig.bench.open();
  other.start_recording();
  try {
    const host::LinkBench link([&] { return rig.bench.open(); }, rig.bench, 0, rig.arm);
    FAIL();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "recording-runs");
  }
}

TEST(LinkCommission, AFaultOfTheDeviceEndsTheStep) {
  Rig rig("arms/paddle");
  ASSERT_EQ(rig.go(2), 3);
  static_cast<void>(rig.bench.controller().request(firmware::Command::kStop));
  rig.bench.open().keep_alive();
  host::Device device = rig.bench.open();
  ASSERT_NE(device.state().fault, 0);
  try {
    const host::LinkBench link([&] { return rig.bench.open(); }, rig.bench, 0, rig.arm);
    FAIL();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "device-faulted");
    EXPECT_EQ(error.code, host::ExitCode::kFaulted);
  }
}

}  // namespace
}  // namespace thimble::test
