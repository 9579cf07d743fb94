// Arms whose joints have drives on CAN, mixed with counters and a converter: what the controller reads and writes of them, and what goes off when.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/board/driven_rig.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

constexpr double kCounts = 4096;  // of a motor's turn, premium-1.5
constexpr float kTorque_N_m_A = .0234F;

// Joint 1 by counter and converter, 2 and 3 by drives of these kinds on one bus.
board::DriveWirings mixed(Kind second, Kind third) {
  return {std::nullopt, wiring_of(config_of(second, 2)), wiring_of(config_of(third, 3), "can0", -1)};
}
// Three of a kind: on one bus where three fit, else the third on another.
board::DriveWirings all_of(Kind kind) {
  const bool fit = is_fd(kind) || kind == Kind::kMiniCheetah;
  return {wiring_of(config_of(kind, 1)), wiring_of(config_of(kind, 2)),
          wiring_of(config_of(kind, 3), fit ? "can0" : "can1")};
}

TEST(DrivenArm, AJointHasItsCountAndCurrentByCounterAndConverterOrByItsDrive) {
  DrivenRig rig(mixed(Kind::kMoteus, Kind::kDamiaoFd));
  ASSERT_EQ(rig.missing(), "");
  rig.encoders->counts = {4711, 0, 0};
  for (std::size_t j = 1; j < 3; ++j) rig.emulated[j]->shaft.inertia_kg_m2 = 1e6;  // they stay
  rig.out.arm[0].current_A = {1, 2, -1.5F};
  rig.tick(5);
  EXPECT_FALSE(rig.any_power());
  EXPECT_EQ(rig.dac->current_A[0], 0);
  ASSERT_TRUE(rig.start());
  rig.tick(20);
  EXPECT_TRUE(rig.enable->active);
  EXPECT_EQ(rig.dac->current_A[0], 1);
  EXPECT_NEAR(rig.emulated[1]->torque_N_m(), 2 * static_cast<double>(kTorque_N_m_A), 1e-4);
  EXPECT_NEAR(rig.emulated[2]->torque_N_m(), 1.5 * static_cast<double>(kTorque_N_m_A),
              .005);  // 12 bits of 10 N m

  const firmware::ArmInputs& in = rig.in.arm[0];
  EXPECT_EQ(in.counts[0], 4711U);
  EXPECT_NEAR(in.evidence.current_A[1], 2, .01);
  EXPECT_NEAR(in.evidence.current_A[2], -1.5, .25);
  EXPECT_TRUE(std::isnan(in.evidence.current_A[0])) << "the converter measures nothing";
  EXPECT_EQ(in.evidence.supply_V, 24);
  EXPECT_EQ(in.evidence.motor_C[2], 38);
  EXPECT_FALSE(in.drive_fault);
  EXPECT_EQ(in.sample_tick, rig.in.tick);
}

TEST(DrivenArm, CountsAreTurnsOfTheDriveInTheModelsRegister) {
  DrivenRig rig(mixed(Kind::kMoteus, Kind::kMoteus), [](DrivenRig& made) {
    made.emulated[1]->shaft.position_rad = 1;
    made.emulated[2]->shaft.position_rad = 1;
  });
  rig.tick(3);
  const double counts = kCounts / (2 * std::numbers::pi);
  EXPECT_NEAR(rig.in.arm[0].counts[1], counts, 1);
  EXPECT_NEAR(rig.in.arm[0].counts[2], 65536 - counts, 1) << "its direction is the other";
  // Ten turns on, at 20 rad/s: the register has wrapped.
  rig.emulated[1]->shaft.inertia_kg_m2 = 1e9;
  rig.emulated[1]->shaft.velocity_rad_s = 20;
  rig.tick(3142);
  // The command went out 0.1 ms after the beginning of the tick before, 1.9 ms ago.
  const double then_rad = rig.emulated[1]->shaft.position_rad - 20 * 1.9e-3;
  const auto expected = static_cast<std::uint32_t>(std::llround(then_rad * counts)) & 0xFFFFU;
  EXPECT_NEAR(rig.in.arm[0].counts[1], expected, 2) << "a tick's motion is 13 counts";
}

// The drive's position is that of its shaft; what the axis counts has its own sign and ratio.
TEST(DrivenArm, CountsHaveTheSignAndRatioOfTheAxis) {
  struct Case {
    float encoder_sign, encoder_turns, drive_sign, drive_turns;
  };
  for (const Case& c : {Case{1, 5, 1, 5}, {-1, 5, -1, 5}, {-1, 5, 1, 5}, {1, 5, -1, 5}, {1, 1, 1, 6}}) {
    kinematics::AxisData axis;
    DrivenRig rig(mixed(Kind::kMoteus, Kind::kMoteus), [&](DrivenRig& made) {
      axis = made.wiring.arm.axis[1];
      axis.encoder_sign = c.encoder_sign;
      axis.encoder_turns = c.encoder_turns;
      axis.drive_sign = c.drive_sign;
      axis.drive_turns = c.drive_turns;
      made.wiring.arm.axis[1] = axis;
      made.emulated[1]->shaft.position_rad = .3;
    });
    rig.tick(3);
    const auto counts = static_cast<std::int16_t>(rig.in.arm[0].counts[1]);
    // What the core makes of the counts, and where the axis is when its motor is at 0.3 rad.
    EXPECT_NEAR(static_cast<float>(counts) * axis.rad_per_count(),
                .3F / (axis.drive_sign * axis.shaft_per_axis()), 2 * std::abs(axis.rad_per_count()));
  }
}

TEST(DrivenArm, OneCommandADriveAndTickTheMostLoadedFirst) {
  DrivenRig rig(all_of(Kind::kMiniCheetah));
  ASSERT_EQ(rig.missing(), "");
  ASSERT_TRUE(rig.start());
  std::vector<board::drives::CanFrame> frames;
  rig.buses.at("can0").emulated->tap = &frames;
  for (const auto& [current_A, order] :
       std::vector<std::pair<std::array<float, 3>, std::vector<std::uint32_t>>>{{{1, 2, -3}, {3, 2, 1}},
                                                                                {{-2, 1, 0}, {1, 2, 3}},
                                                                                {{0, 0, 0}, {1, 2, 3}},
                                                                                {{0, 0, 1}, {3, 1, 2}}}) {
    frames.clear();
    std::ranges::copy(current_A, rig.out.arm[0].current_A.begin());
    rig.tick();
    std::vector<std::uint32_t> ids;
    for (const auto& frame : frames)
      if (frame.id < 16) ids.push_back(frame.id);
    EXPECT_EQ(ids, order);
  }
}

// The whole life of each kind: found, position known, on, torque, off.
TEST(DrivenArm, EveryKindLives) {
  for (const Kind kind : kKinds) {
    SCOPED_TRACE(name_of_kind(kind));
    DrivenRig rig(all_of(kind));
    ASSERT_EQ(rig.missing(), "");
    EXPECT_EQ(rig.set().report().size(), 3 + rig.buses.size());
    for (const std::string& line : rig.set().report()) std::printf("%s\n", line.c_str());
    rig.tick(1200);  // an ODrive learns its position
    EXPECT_EQ(rig.in.arm[0].sample_tick, rig.in.tick);
    EXPECT_FALSE(rig.any_power());
    EXPECT_FALSE(rig.in.arm[0].drive_fault);
    ASSERT_TRUE(rig.start());
    rig.out.arm[0].current_A = {1, 1, 1};
    rig.tick(15);
    for (const EmulatedDrive* one : rig.emulated) EXPECT_GT(one->torque_N_m(), .015);
    EXPECT_FALSE(rig.in.arm[0].drive_fault);
    rig.out.arm[0].enable = false;
    rig.out.mode = firmware::Mode::kReady;
    rig.tick(2);
    EXPECT_FALSE(rig.any_power());
    rig.tick(300);
    EXPECT_TRUE(rig.start()) << "and again";
  }
}

TEST(DrivenArm, AnOdriveIsSwitchedOnOnceForItsPositionWithTheEStopClosed) {
  DrivenRig rig(all_of(Kind::kOdrive06));
  rig.in.e_stop = true;
  rig.tick(1000);
  EXPECT_FALSE(rig.any_power());
  EXPECT_LT(rig.in.arm[0].sample_tick, 3U);
  rig.in.e_stop = false;
  bool powered = false;
  for (int i = 0; i < 1000; ++i) {
    rig.tick();
    powered = powered || rig.any_power();
    for (const EmulatedDrive* one : rig.emulated) EXPECT_NEAR(one->torque_N_m(), 0, 1e-9);
  }
  EXPECT_TRUE(powered);
  EXPECT_FALSE(rig.any_power());
  EXPECT_EQ(rig.in.arm[0].sample_tick, rig.in.tick);
  for (int i = 0; i < 2000; ++i) {
    rig.tick();
    ASSERT_FALSE(rig.any_power()) << "once";
  }
}

// As when another arm is stored on the board, right after its fault was cleared.
TEST(DrivenArm, AnOdriveIsSwitchedOnAgainForItsPositionWhenTheControllerStartsAnewMeanwhile) {
  DrivenRig rig(all_of(Kind::kOdrive05));
  for (int i = 0; i < 1000 && !rig.any_power(); ++i) rig.tick();
  ASSERT_TRUE(rig.any_power());
  rig.devices->switch_off();
  rig.devices->forget();
  ASSERT_LT(rig.in.arm[0].sample_tick, 3U) << "not known yet";
  rig.tick(1500);
  EXPECT_FALSE(rig.any_power());
  EXPECT_EQ(rig.in.arm[0].sample_tick, rig.in.tick);
}

// With the real controller: its homed arm, whose drive falls silent.
TEST(DrivenArm, ASilentDriveIsAStaleSampleAndAFault) {
  for (const bool armed : {false, true}) {
    DrivenRig rig(all_of(Kind::kMoteus));
    firmware::Config config;
    config.period_s = 1e-3F;
    Bench bench(config);
    if (armed) bench.load(1000, -1);  // nothing to touch
    rig.control = [&bench](DrivenRig& made) {
      bench.controller->keep_alive();
      made.out = bench.controller->tick(made.in);
      bench.controller->poll(made.in.time_us);
    };
    rig.tick(50);
    ASSERT_EQ(bench.controller->request(Command::kHome), 0);
    rig.tick(3);
    ASSERT_EQ(bench.mode(), Mode::kReady);
    if (armed) {
      ASSERT_EQ(bench.controller->request(Command::kArm), 0);
      rig.tick(200);
      ASSERT_EQ(bench.mode(), Mode::kArmed);
      ASSERT_EQ(rig.set().gain(), 1);
    }
    rig.emulated[1]->inject.mute = true;
    rig.tick(6);
    EXPECT_EQ(bench.mode(), Mode::kFaulted);
    EXPECT_TRUE(bench.shown().fault == Fault::encoder_stale || bench.shown().fault == Fault::drive_fault);
    EXPECT_LT(rig.in.arm[0].sample_tick + 2, rig.in.tick);
    EXPECT_NE(rig.set().news().find("joint 2 (moteus 2 on can0): silent"), std::string::npos);
    rig.tick(600);
    EXPECT_FALSE(rig.emulated[0]->powered() || rig.emulated[2]->powered());
  }
}

TEST(DrivenArm, ADriveThatRestartsIsNotEnabledUntilTheFaultIsClearedAndTheControllerArms) {
  for (const Kind kind : {Kind::kMoteus, Kind::kDamiao, Kind::kOdrive06}) {
    SCOPED_TRACE(name_of_kind(kind));
    DrivenRig rig(all_of(kind));
    rig.tick(1200);
    ASSERT_TRUE(rig.start());
    rig.emulated[1]->power_cycle(50'000);
    // The controller goes on asking for its motors: it has not seen the fault yet.
    rig.tick(10);
    EXPECT_TRUE(rig.in.arm[0].drive_fault || kind == Kind::kOdrive06);
    rig.tick(1000);
    EXPECT_TRUE(rig.in.arm[0].drive_fault);
    EXPECT_FALSE(rig.any_power());
    rig.fault_latched();
    rig.tick(500);
    EXPECT_FALSE(rig.in.arm[0].drive_fault) << "or nobody could clear it";
    EXPECT_FALSE(rig.any_power());
    rig.out.arm[0].enable = true;  // no controller does that
    rig.tick(500);
    EXPECT_FALSE(rig.any_power());
    rig.out.arm[0].enable = false;
    rig.in.e_stop = true;  // an ODrive is not asked for its position
    rig.fault_cleared();
    rig.tick(1500);
    EXPECT_FALSE(rig.any_power());
    EXPECT_FALSE(rig.in.arm[0].drive_fault);
    rig.in.e_stop = false;
    EXPECT_TRUE(rig.start());
  }
}

TEST(DrivenArm, MakeSafeSwitchesOffAtOnceAndOutOfTurn) {
  for (const Kind kind : kKinds) {
    SCOPED_TRACE(name_of_kind(kind));
    DrivenRig rig(all_of(kind));
    rig.tick(1200);
    ASSERT_TRUE(rig.start());
    ASSERT_TRUE(rig.any_power());
    rig.devices->switch_off();
    rig.devices->forget();
    rig.run_until(rig.now_us + 200);
    EXPECT_FALSE(rig.any_power());
    rig.out = {};
    rig.run_until(rig.now_us + 40'000);  // the board starts its controller again
    rig.tick(1500);
    EXPECT_FALSE(rig.any_power());
    EXPECT_FALSE(rig.in.arm[0].drive_fault);
    EXPECT_TRUE(rig.start());
  }
}

// The guardian's process sends alone; the board that resumes finds them off.
TEST(DrivenArm, WhatTheGuardianSwitchesOffStaysOff) {
  for (const Kind kind : kKinds) {
    SCOPED_TRACE(name_of_kind(kind));
    DrivenRig rig(all_of(kind));
    rig.tick(1200);
    ASSERT_TRUE(rig.start());
    rig.out.arm[0].current_A = {1, 1, 1};
    rig.tick(5);
    rig.beat->cut_drives();
    rig.devices->switch_off();
    rig.run_until(rig.now_us + 5000);
    EXPECT_FALSE(rig.any_power());
    for (int i = 0; i < 500; ++i) {
      rig.tick();
      ASSERT_FALSE(rig.any_power()) << i;
    }
    EXPECT_TRUE(rig.in.arm[0].drive_fault);
    EXPECT_NE(rig.set().news().find("switched_off"), std::string::npos);
    rig.fault_latched();
    rig.beat->off();
    rig.tick(400);
    EXPECT_FALSE(rig.in.arm[0].drive_fault);
  }
}

TEST(DrivenArm, AConverterThatFailsSwitchesTheDrivesOff) {
  DrivenRig rig(mixed(Kind::kMoteus, Kind::kDamiaoFd));
  ASSERT_TRUE(rig.start());
  rig.dac->broken = true;
  rig.tick(3);
  EXPECT_TRUE(rig.in.arm[0].drive_fault);
  EXPECT_FALSE(rig.any_power());
  EXPECT_FALSE(rig.enable->active);
}

TEST(DrivenArm, AFaultOfOneBusDropsTheOthersAndTheConverter) {
  board::DriveWirings wirings = {std::nullopt, wiring_of(config_of(Kind::kMoteus, 1), "can0"),
                                 wiring_of(config_of(Kind::kDamiao, 1), "can1")};
  DrivenRig rig(std::move(wirings));
  ASSERT_EQ(rig.missing(), "");
  ASSERT_TRUE(rig.start());
  rig.out.arm[0].current_A = {1, 1, 1};
  rig.tick(5);
  rig.emulated[1]->fail(34);
  rig.tick(2);
  EXPECT_TRUE(rig.in.arm[0].drive_fault);
  EXPECT_EQ(rig.dac->current_A[0], 0);
  rig.tick(5);
  EXPECT_NEAR(rig.emulated[2]->torque_N_m(), 0, .005);
  rig.tick(350);
  EXPECT_FALSE(rig.any_power());
}

// The measured current is compared by the controller with the present command: a late reply must not look like a wrong current, half a current must.
TEST(DrivenArm, TheMeasuredCurrentHasNoLagAndShowsWhatIsMissing) {
  DrivenRig rig(all_of(Kind::kMoteus));
  for (EmulatedDrive* one : rig.emulated) one->shaft.inertia_kg_m2 = 1e6;
  ASSERT_TRUE(rig.start());
  float most_A = 0;
  rig.control = [&most_A](DrivenRig& made) {  // before the next command is set
    const float off_A = made.in.arm[0].evidence.current_A[0] - made.out.arm[0].current_A[0];
    if (made.in.tick % 400 > 5) most_A = std::max(most_A, std::abs(off_A));
    const auto step = static_cast<int>(made.in.tick % 40);
    made.out.arm[0].current_A[0] = .1F * static_cast<float>(step < 20 ? step : 40 - step);  // 0.1 A a tick
  };
  rig.tick(380);
  EXPECT_LT(most_A, .1F);
  EXPECT_GT(most_A, 0);
  rig.control = {};
  rig.emulated[0]->inject.current_factor = .5;
  rig.out.arm[0].current_A = {2, 0, 0};
  rig.tick(20);
  EXPECT_NEAR(rig.in.arm[0].evidence.current_A[0], 1, .05);
}

TEST(DrivenArm, TheOldestSampleOfAnArmIsItsSample) {
  DrivenRig rig(mixed(Kind::kMoteus, Kind::kMoteus));
  rig.tick(10);
  EXPECT_EQ(rig.in.arm[0].sample_tick, rig.in.tick);
  rig.encoders->silent = true;
  rig.tick(3);
  EXPECT_EQ(rig.in.arm[0].sample_tick + 3, rig.in.tick);
  rig.encoders->silent = false;
  rig.emulated[2]->inject.drop_replies = 1;
  rig.tick(2);
  EXPECT_EQ(rig.in.arm[0].sample_tick + 1, rig.in.tick);
}

// The controller with the simulated arm behind drives of each kind: a hand presses the tip onto a floor for a second, and no fault comes.
TEST(DrivenArm, TouchesAFloorWithEachKind) {
  for (const Kind kind : kKinds) {
    SCOPED_TRACE(name_of_kind(kind));
    board::DriveWirings wirings = all_of(kind);
    for (auto& one : wirings) {
      one->config.base_damping_N_m_s_rad = is_odrive(kind) ? 0 : .0005F;
      one->config.top_speed_rad_s = 500;
    }
    DrivenRig rig(std::move(wirings));
    ASSERT_EQ(rig.missing(), "");
    firmware::Config config;
    config.period_s = 1e-3F;
    Bench bench(config);
    bench.load(1000, -.01F);
    rig.attach_arm(board::HandPath({{0, {0, 0, 0}}, {.3, {0, 0, 0}}, {.6, {0, 0, -.025}}}));
    rig.control = [&bench](DrivenRig& made) {
      bench.controller->keep_alive();
      made.out = bench.controller->tick(made.in);
      bench.controller->poll(made.in.time_us);
    };
    rig.tick(1200);
    ASSERT_EQ(bench.controller->request(Command::kHome), 0);
    rig.tick(3);
    ASSERT_EQ(bench.controller->request(Command::kArm), 0);
    float most_N = 0;
    for (int i = 0; i < 2500 && bench.mode() != Mode::kFaulted; ++i) {
      rig.tick();
      most_N = std::max(most_N, bench.force_N());
    }
    EXPECT_EQ(bench.mode(), Mode::kArmed)
        << "fault " << static_cast<int>(bench.shown().fault) << ' ' << rig.set().news();
    std::printf("%s: most %.2f N\n", name_of_kind(kind).c_str(), static_cast<double>(most_N));
    EXPECT_GT(most_N, .3F);
    EXPECT_LT(most_N, 6);
  }
}

// What stands against arming is named at start.
TEST(DrivenArm, WhatIsMissingIsNamed) {
  const auto missing = [](board::DriveWirings drives, const DrivenRig::Prepare& prepare,
                          double rate_Hz = 1000) {
    const DrivenRig rig(std::move(drives), prepare, rate_Hz);
    std::printf("%s", rig.missing().c_str());
    return rig.missing();
  };
  using testing::HasSubstr;
  EXPECT_THAT(missing(all_of(Kind::kMoteus), [](DrivenRig& rig) { rig.emulated[1]->inject.mute = true; }),
              HasSubstr("no_drive: arm 0 joint 2 (moteus 2 on can0): does not answer; check its power"));
  EXPECT_THAT(
      missing(all_of(Kind::kMoteus), [](DrivenRig& rig) { rig.emulated[0]->set_watchdog_s(.1); }),
      HasSubstr(
          "drive_config_differs: arm 0 joint 1 (moteus 1 on can0): a value of the drive's configuration is "
          "not the one of the file (servo.default_timeout_s); write the value"));
  EXPECT_THAT(
      missing(all_of(Kind::kOdrive05), [](DrivenRig& rig) { rig.emulated[2]->inject.watchdog_off = true; }),
      HasSubstr("drive_watchdog_unproven: arm 0 joint 3 (odrive_0.5 3 on can1)"));
  EXPECT_THAT(missing(all_of(Kind::kMoteus), [](DrivenRig& rig) { rig.buses.at("can0").absent = true; }),
              HasSubstr("no_drive_bus: cannot use can0; set the interface up"));
  EXPECT_THAT(missing(all_of(Kind::kDamiao), [](DrivenRig& rig) { rig.emulated[0]->inject.reply_id = 0x55; }),
              HasSubstr("strange_drive: can0: a frame with the id 0x55 and 8 bytes"));
  EXPECT_THAT(
      missing(all_of(Kind::kOdrive05), {}, 1500),
      HasSubstr("drive_bus_overloaded: two damped ODrives at 1.5 kHz need 81 % of can0, of which 80 % may be "
                "used; move drives to another bus, or lower the rate"));
}

}  // namespace
}  // namespace thimble::test
