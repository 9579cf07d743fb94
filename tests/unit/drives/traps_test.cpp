// What goes wrong with motor drives on CAN, a trap a test: the emulated drive does it, and the driver guards against it or names it.
// docs/drives.md has the table.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "board/linux/drives/mit.h"
#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"
#include "tests/unit/drives/hex.h"
#include "tests/unit/drives/rig.h"

namespace thimble::test {
namespace {

std::vector<DriveConfig> two(Kind kind, const std::function<void(DriveConfig&)>& change) {
  std::vector<DriveConfig> configs = {config_of(kind, 1), config_of(kind, 2)};
  for (DriveConfig& config : configs) change(config);
  return configs;
}

// An emulated drive alone, with hand-made frames.
template <class Drive>
class Bench {
 public:
  explicit Bench(std::unique_ptr<Drive> made)
      : emulated(std::move(ends_.second)),
        drive(emulated.add(std::move(made))),
        host(std::move(ends_.first)) {
    wait_us(25);
  }
  void wait_us(std::uint64_t us) {
    for (const std::uint64_t end = now_us_ + us; now_us_ < end;) emulated.run(now_us_ += 25);
  }
  void send(const board::drives::CanFrame& frame) {
    EXPECT_EQ(host.send(std::span(&frame, 1)), board::drives::CanSocket::Sent::kAll);
    emulated.run(now_us_);
  }
  // The last frame that came.
  board::drives::CanFrame last() {
    wait_us(500);
    const auto received = host.receive(now_us_);
    return received.empty() ? board::drives::CanFrame{} : received.back().frame;
  }

 private:
  std::pair<Descriptor, Descriptor> ends_ = socket_pair();
  std::uint64_t now_us_ = 1'000'000;

 public:
  EmulatedBus emulated;
  Drive& drive;
  board::drives::CanSocket host;
};

// "turns, rad, output, rotor": Units.OneTurn has it in hex; here the joint turns (EveryKind.ReportsPositionAndVelocityInRadians).

// "sign of encoder and of torque differ": no reply shows it, because the torque reported is the current's. Motion does.
TEST(DriveTraps, TwoSwappedPhasesAreSeenByMotionAlone) {
  DriveRig rig(Kind::kMoteus);
  ASSERT_TRUE(rig.start());
  rig.drive(0).inject.torque_factor = -1;
  rig.torque_N_m = {.1F, .1F};
  rig.tick(20);
  EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  EXPECT_NEAR(rig.states[0].torque_N_m, rig.states[1].torque_N_m, .02);
  EXPECT_LT(rig.states[0].velocity_rad_s, -.5);
  EXPECT_GT(rig.states[1].velocity_rad_s, .5);
}

// "gear ratio twice".
TEST(DriveTraps, TheGearRatioInTheDriveIsReadBack) {
  static const board::drives::ConfigItem kRatio[] = {{"motor_position.rotor_to_output_ratio", 0, false, 1}};
  DriveRig rig(two(Kind::kMoteus, [](DriveConfig& config) { config.items = kRatio; }));
  rig.drive<EmulatedMoteus>(0).config["motor_position.rotor_to_output_ratio"] = .125;
  rig.tick(400);
  EXPECT_EQ(rig.states[0].fault, DriveFault::kConfigDiffers);
  EXPECT_STREQ(rig.states[0].wrong_item, "motor_position.rotor_to_output_ratio");
  EXPECT_EQ(rig.states[1].state, State::kIdle);
}

// "wrap".
TEST(DriveTraps, APositionThatWrapsGoesOn) {
  for (const Kind kind : {Kind::kMiniCheetah, Kind::kDamiaoFd}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = 1e6;
    rig.drive(0).shaft.velocity_rad_s = 20;
    rig.tick(3000);
    EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
    EXPECT_NEAR(rig.states[0].position_rad, 60, .5);
  }
}

TEST(DriveTraps, AJointParkedATurnOffIsRefusedAtStart) {
  DriveRig rig(two(Kind::kDamiao, [](DriveConfig& config) {
    config.start_lo_rad = -2;
    config.start_hi_rad = 4;
  }));
  rig.drive(0).shaft.position_rad = 3.5;  // beyond half a turn from zero: boots 360 degrees off
  rig.drive(0).reboot();
  rig.tick(400);
  EXPECT_EQ(rig.states[0].fault, DriveFault::kStartPose) << rig.text();
  EXPECT_NEAR(rig.states[0].position_rad, 3.5 - 2 * std::numbers::pi, .01);
}

// "speed limit bends torque".
TEST(DriveTraps, TheVelocityLimitOfAnOdriveTakesNoTorque) {
  for (const float base : {0.0F, .005F}) {
    DriveRig rig(two(Kind::kOdrive05, [base](DriveConfig& config) { config.base_damping_N_m_s_rad = base; }));
    EXPECT_EQ(rig.drive<EmulatedOdrive>(0).config.velocity_limit_turns_s, 2);  // as shipped
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = 1e6;
    rig.drive(0).shaft.velocity_rad_s = 25;  // 4 turns/s
    rig.torque_N_m = {.3F, 0};
    rig.tick(100);
    EXPECT_NEAR(rig.drive(0).torque_N_m(), .3 - static_cast<double>(base) * 25, .01) << base;
    EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  }
}

// "ramps and filters".
TEST(DriveTraps, TheTorqueRampOfAnOdriveIsOff) {
  DriveRig rig(Kind::kOdrive05);
  EXPECT_EQ(rig.drive<EmulatedOdrive>(0).config.input_mode, 6);  // 10 mN m/s as shipped
  ASSERT_TRUE(rig.start());
  rig.drive(0).shaft.inertia_kg_m2 = 1e6;
  rig.torque_N_m = {.3F, 0};
  rig.tick(8);
  EXPECT_NEAR(rig.drive(0).torque_N_m(), .3, .01);
}

// "derating unseen".
TEST(DriveTraps, DeratingThatIsNotReportedIsShownThenAFault) {
  for (const Kind kind :
       {Kind::kMoteus, Kind::kOdrive05, Kind::kOdrive06, Kind::kMiniCheetah, Kind::kDamiaoFd}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = 1e6;
    rig.drive(0).inject.current_factor = .5;
    rig.torque_N_m = {.3F, 0};
    rig.tick(15);
    EXPECT_EQ(rig.states[0].limiter, Limiter::kNone) << name_of_kind(kind);
    rig.tick(35);
    EXPECT_EQ(rig.states[0].limiter, Limiter::kUnseen) << name_of_kind(kind);
    EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
    rig.tick(200);
    EXPECT_TRUE(rig.dropped(DriveFault::kTorqueDiffers)) << name_of_kind(kind);
  }
}

// A tone as often as the reports come meets them always in the same phase; commissioning plays tones up to a fifth of the rate.
TEST(DriveTraps, ATorqueThatAlternatesIsNoDerating) {
  for (const Kind kind :
       {Kind::kMoteus, Kind::kOdrive05, Kind::kOdrive06, Kind::kMiniCheetah, Kind::kDamiaoFd}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = 1e6;
    unsigned off = 0;
    for (float Hz = 12; Hz <= 200; Hz += Hz < 90 || Hz > 110 ? 11.3F : .5F)
      for (unsigned tick = 0; tick < 250; ++tick) {
        rig.torque_N_m = {.3F * std::cos(6.2832F * Hz * 1e-3F * static_cast<float>(tick)), 0};
        rig.tick();
        ASSERT_TRUE(rig.all(State::kRunning)) << name_of_kind(kind) << ' ' << Hz << " Hz: " << rig.text();
        ASSERT_EQ(rig.states[0].limiter, Limiter::kNone) << name_of_kind(kind) << ' ' << Hz << " Hz";
        off = std::abs(rig.states[0].torque_difference_N_m) > .03F ? off + 1
                                                                   : 0;  // where a tone begins with a step
        ASSERT_LE(off, 2U) << name_of_kind(kind) << ' ' << Hz << " Hz";
      }
  }
}

TEST(DriveTraps, ALimiterThatIsReportedIsShownAndNeverLatched) {
  DriveRig rig(Kind::kMoteus);
  ASSERT_TRUE(rig.start());
  rig.drive<EmulatedMoteus>(0).limiter = 99;
  rig.tick(300);
  EXPECT_EQ(rig.states[0].limiter, Limiter::kCurrent);
  EXPECT_TRUE(rig.all(State::kRunning));
  rig.drive<EmulatedMoteus>(0).limiter = 0;
  rig.tick(2);
  EXPECT_EQ(rig.states[0].limiter, Limiter::kNone);
}

// "stale reply taken for fresh": EveryKind.OneLostReplyIsNotTakenForFreshAndThreeAreSilence, and the drive's clock that stands (kStale).

// "late reply answers the tick before".
// Whether it comes before the next command or just after it.
TEST(DriveTraps, AReplyOfTheTickBeforeIsNotTakenForFresh) {
  for (const Kind kind : {Kind::kMoteus, Kind::kMiniCheetah, Kind::kDamiao, Kind::kDamiaoFd})
    for (const unsigned delay_us : {600U, 940U}) {
      SCOPED_TRACE(name_of_kind(kind) + ' ' + std::to_string(delay_us));
      DriveRig rig(kind);
      ASSERT_TRUE(rig.start());
      rig.drive(0).shaft.inertia_kg_m2 = 1e6;
      rig.drive(0).shaft.velocity_rad_s = 5;
      rig.tick();
      const double position = rig.states[0].position_rad;
      const float velocity = rig.states[0].velocity_rad_s;
      rig.drive(0).shaft.velocity_rad_s = 7;
      rig.drive(0).inject.more_delay_us = delay_us;
      rig.tick(2);
      EXPECT_FALSE(rig.states[0].fresh);
      EXPECT_EQ(rig.states[0].position_rad, position);
      EXPECT_EQ(rig.states[0].velocity_rad_s, velocity);
      EXPECT_EQ(rig.states[0].late_replies, 1U);
      rig.tick(1);
      EXPECT_TRUE(rig.dropped(DriveFault::kSilent));
    }
}

TEST(DriveTraps, TwoDrivesMayAnswerInAnyOrder) {
  DriveRig rig(Kind::kDamiaoFd);
  ASSERT_TRUE(rig.start());
  rig.drive(0).shaft.position_rad += 1e-2;
  for (int i = 0; i < 20; ++i) {
    rig.emulated.swap_next_two = true;
    rig.tick();
  }
  EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  EXPECT_NEAR(rig.states[0].position_rad - rig.states[1].position_rad, 1e-2, 2e-3);
}

// "reply on an unexpected id, FD answered classic".
TEST(DriveTraps, AReplyOnAnUnexpectedIdRefusesArmingAndIsListed) {
  DriveRig rig(Kind::kDamiao);
  rig.drive(0).inject.reply_id = 0x55;
  rig.tick(400);
  EXPECT_EQ(rig.states[0].state, State::kUnknown);
  ASSERT_EQ(rig.bus.strangers().size(), 1U);
  EXPECT_EQ(rig.bus.strangers()[0].id, 0x55U);
  EXPECT_EQ(rig.bus.strangers()[0].size, 8);
  EXPECT_FALSE(rig.bus.strangers()[0].fd);
  EXPECT_EQ(rig.bus.enable(), "a frame on the bus has an id that no drive of the list sends");
}

TEST(DriveTraps, FdAnsweredClassicRefusesArming) {
  DriveRig rig(Kind::kDamiaoFd);
  rig.drive(0).inject.answer_classic = true;
  rig.tick(50);
  EXPECT_EQ(rig.states[0].fault, DriveFault::kWrongFrame);
  EXPECT_EQ(rig.bus.enable(), "a drive is not idle");
}

TEST(DriveTraps, ADriveThatTakesNoFdFramesIsNotFound) {
  DriveRig rig(Kind::kDamiaoFd);
  rig.drive<EmulatedMit>(0).takes_fd = false;
  rig.tick(100);
  EXPECT_EQ(rig.states[0].state, State::kUnknown);
}

TEST(DriveTraps, TwoMotorsOnOneReplyIdAreNamed) {
  DriveRig rig(Kind::kMiniCheetah);
  ASSERT_TRUE(rig.until_all(State::kIdle));
  rig.drive(1).inject.reply_id = 17;  // of motor 1
  rig.tick(2);
  EXPECT_EQ(rig.states[0].fault, DriveFault::kTwoReplies) << rig.text();
}

// "over-voltage on braking": the drive switches off by itself; the supply is shown all the time.
TEST(DriveTraps, OverVoltageIsTheDrivesOwnFault) {
  const std::pair<Kind, std::uint32_t> kCodes[] = {
      {Kind::kMoteus, 34}, {Kind::kOdrive06, 0x100}, {Kind::kCubeMars, 3}, {Kind::kDamiao, 8}};
  for (const auto& [kind, code] : kCodes) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    if (kind == Kind::kMoteus) {
      EXPECT_EQ(rig.states[0].supply_V, 24);
    }
    rig.drive(0).fail(code);
    rig.tick(110);  // ODrive: with its next heartbeat
    EXPECT_TRUE(rig.dropped(DriveFault::kDriveReported)) << name_of_kind(kind);
    EXPECT_EQ(rig.states[0].drive_fault, code);
    rig.tick(500);
    EXPECT_EQ(rig.states[0].drive_fault, code) << "kept, though the drive's is cleared";
  }
}

// "drive reboots in use".
TEST(DriveTraps, ADriveThatRestartsIsNotEnabledAgain) {
  for (const Kind kind : kKinds) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.torque_N_m = {.1F, .1F};
    rig.drive(0).power_cycle(30'000);
    for (int i = 0; i < 1000; ++i) {
      rig.tick();
      ASSERT_FALSE(rig.drive(0).powered()) << name_of_kind(kind) << ' ' << i;
    }
    EXPECT_EQ(rig.states[0].state, State::kSilent) << name_of_kind(kind);
  }
}

// Without a lost reply. A moteus takes the next command, which carries its mode: it is on for three ticks, with the torque asked for.
TEST(DriveTraps, ADriveThatRestartsAtOnceIsNamed) {
  for (const Kind kind : {Kind::kMoteus, Kind::kOdrive05, Kind::kOdrive06, Kind::kDamiao, Kind::kDamiaoFd}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.torque_N_m = {.1F, .1F};
    rig.drive(0).reboot();
    for (int i = 0; i < 1000; ++i) {
      rig.tick();
      ASSERT_FALSE(rig.drive(0).powered() && (i > 3 || kind != Kind::kMoteus))
          << name_of_kind(kind) << ' ' << i;
    }
    EXPECT_EQ(rig.states[0].fault, DriveFault::kRebooted) << name_of_kind(kind) << rig.text();
    EXPECT_EQ(rig.states[0].state, State::kFault);
  }
}

// "saved config not what we think": DriveFaults (kConfigDiffers), and the watchdog of each kind that can tell.
TEST(DriveTraps, AWatchdogThatIsOffRefusesArming) {
  DriveRig damiao(Kind::kDamiao);
  damiao.drive<EmulatedMit>(0).registers[9] = 0;
  damiao.tick(400);
  EXPECT_STREQ(damiao.states[0].wrong_item, "TIMEOUT");
  DriveRig odrive(Kind::kOdrive06);
  odrive.drive<EmulatedOdrive>(0).endpoints[100] = 0;
  odrive.tick(400);
  EXPECT_STREQ(odrive.states[0].wrong_item, "axis0.config.enable_watchdog");
  DriveRig old(Kind::kOdrive05);
  old.drive<EmulatedOdrive>(0).config.watchdog = false;
  old.tick(1500);
  EXPECT_EQ(old.states[0].fault, DriveFault::kWatchdogUnproven);
  DriveRig moteus(Kind::kMoteus);
  moteus.drive<EmulatedMoteus>(0).config["servo.default_timeout_s"] = .1;
  moteus.tick(400);
  EXPECT_STREQ(moteus.states[0].wrong_item, "servo.default_timeout_s");
  for (const char* name : {"servo.timeout_mode", "servo.pid_position.ki"}) {
    DriveRig limp(Kind::kMoteus);
    limp.drive<EmulatedMoteus>(0).config[name] = 10;
    limp.tick(400);
    EXPECT_EQ(limp.states[0].wrong_item, std::string(name));
  }
  DriveRig mit(two(Kind::kMiniCheetah, [](DriveConfig& config) { config.watchdog_proven = false; }));
  mit.tick(400);
  EXPECT_EQ(mit.states[0].fault, DriveFault::kWatchdogUnproven);
}

// What each drive does when the host is silent.
TEST(DriveTraps, WhenTheHostIsSilentEachDriveDoesWhatItsKindDoes) {
  for (const Kind kind : kKinds) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.torque_N_m = {.2F, .2F};
    rig.tick(20);
    const double begin = rig.drive(0).shaft.velocity_rad_s;
    rig.pause(40);  // the torque goes on until the watchdog
    const double speed = rig.drive(0).shaft.velocity_rad_s;
    EXPECT_GT(speed, begin + 1) << name_of_kind(kind);
    rig.pause(100);
    const bool damps = kind == Kind::kMoteus;  // with the last kd_scale: 5 + 1 mN m s/rad on 1 g m2
    EXPECT_NEAR(rig.drive(0).shaft.velocity_rad_s, speed * std::exp(damps ? -.6 : -.1), .05 * speed)
        << name_of_kind(kind);
    EXPECT_EQ(rig.drive(0).powered(),
              kind == Kind::kMoteus || kind == Kind::kMiniCheetah || kind == Kind::kCubeMars);
    // Back again: it is a gap, and no torque comes back.
    rig.tick(1);
    EXPECT_EQ(rig.states[0].fault, DriveFault::kHostGap) << name_of_kind(kind) << rig.text();
    rig.tick(20);
    EXPECT_LT(std::abs(rig.drive(0).torque_N_m()), .04) << name_of_kind(kind);
    rig.tick(500);
    EXPECT_FALSE(rig.drive(0).powered()) << name_of_kind(kind);
  }
}

// moteus

TEST(DriveTraps, AMoteusWithoutDampingInItsLastCommandCoastsOnSilenceAndBrakesWithMode15) {
  for (const double mode : {12.0, 15.0}) {
    Bench bench(std::make_unique<EmulatedMoteus>(std::uint8_t{1}));
    bench.drive.config["servo.timeout_mode"] = mode;
    bench.drive.shaft.velocity_rad_s = 10;
    bench.send(board::drives::moteus::pack_motion(1, {0, 0, 10}, board::drives::moteus::Query::kNone));
    bench.wait_us(111'000);
    EXPECT_EQ(bench.drive.mode(), 11);
    EXPECT_NEAR(bench.drive.shaft.velocity_rad_s, 10 * std::exp(mode == 12 ? -.111 : -1.111), .1);
  }
}

TEST(DriveTraps, AMoteusCommandWithTheModeAloneIsAStepToTurn0WithFullGain) {
  Bench bench(std::make_unique<EmulatedMoteus>(std::uint8_t{1}));
  bench.drive.shaft.position_rad = 2 * std::numbers::pi;
  bench.drive.shaft.inertia_kg_m2 = 1e6;
  auto mode_alone = frame_of_hex(0x8001, "01000a505050", true);
  mode_alone.size = 6;
  bench.send(mode_alone);
  bench.wait_us(5000);
  EXPECT_LT(bench.drive.torque_N_m(), -3.5);  // kp 4 N m a turn
  // Every command of the codec says otherwise, after it too.
  bench.send(board::drives::moteus::pack_motion(1, {.1F, 0, 10}, board::drives::moteus::Query::kNone));
  bench.wait_us(5000);
  EXPECT_NEAR(bench.drive.torque_N_m(), .1, 1e-3);
}

TEST(DriveTraps, ModeNineOfAMoteusHasNoWatchdog) {
  Bench bench(std::make_unique<EmulatedMoteus>(std::uint8_t{1}));
  bench.send(frame_of_hex(0x8001, "010009 0d22cdcccc3d 5050 50", true));
  bench.wait_us(500'000);
  EXPECT_EQ(bench.drive.mode(), 9);  // the codec never sends it: drives.codecs_against_python
  EXPECT_NEAR(bench.drive.torque_N_m(), .1, .05);
}

TEST(DriveTraps, ATimeoutOfAMoteusIsLatchedUntilItIsStopped) {
  Bench bench(std::make_unique<EmulatedMoteus>(std::uint8_t{1}));
  const auto motion =
      board::drives::moteus::pack_motion(1, {.1F, 0, 10}, board::drives::moteus::Query::kNone);
  bench.send(motion);
  bench.wait_us(20'000);
  bench.send(motion);
  bench.wait_us(2000);
  EXPECT_EQ(bench.drive.mode(), 11);
  bench.send(board::drives::moteus::pack_stop(1, board::drives::moteus::Query::kNone));
  bench.send(motion);
  bench.wait_us(2000);
  EXPECT_EQ(bench.drive.mode(), 10);
}

TEST(DriveTraps, ASilentMoteusGetsNoCommandThatWouldEnableItAfterAReboot) {
  DriveRig rig(Kind::kMoteus);
  ASSERT_TRUE(rig.start());
  rig.drive(0).inject.mute = true;
  rig.tick(20);
  ASSERT_EQ(rig.states[0].state, State::kSilent);
  rig.drive(0).reboot();
  rig.drive(0).inject.mute = false;
  for (int i = 0; i < 600; ++i) {
    rig.tick();
    ASSERT_EQ(rig.drive<EmulatedMoteus>(0).mode(), 0) << i;
  }
}

// ODrive

TEST(DriveTraps, AnyFrameFeedsTheWatchdogOfAnOdrive) {
  Bench bench(std::make_unique<EmulatedOdrive>(std::uint8_t{3}, false));
  namespace odrive = board::drives::odrive;
  bench.send(odrive::pack_controller_modes(3, odrive::ControlMode::kTorque));
  bench.send(odrive::pack_axis_state(3, odrive::AxisState::kClosedLoop));
  bench.send(odrive::pack_torque(3, .1F));
  for (int i = 0; i < 100; ++i) {  // a poller lives on after the torque thread
    bench.send(odrive::pack_request(3, odrive::Message::kSupply));
    bench.wait_us(1000);
  }
  EXPECT_TRUE(bench.drive.powered());  // the last torque is still on
  bench.wait_us(20'000);
  EXPECT_EQ(bench.drive.error(), 0x800U);
}

TEST(DriveTraps, NothingButACycleSendsToAnOdrive) {
  DriveRig rig(two(Kind::kOdrive05, [](DriveConfig& config) {
    config.request_estimates = true;
    config.reply_period_s = 0;
  }));
  ASSERT_TRUE(rig.start());
  rig.torque_N_m = {.1F, .1F};
  rig.tick(10);
  EXPECT_TRUE(rig.states[0].fresh);
  const std::uint64_t heard = rig.emulated.heard();
  for (int i = 0; i < 30; ++i) {
    (void)rig.bus.collect(rig.now_us);
    rig.pause(1);
  }
  (void)rig.bus.enable();
  rig.bus.disable();
  rig.pause(1);
  EXPECT_EQ(rig.emulated.heard(), heard);
  EXPECT_FALSE(rig.drive(0).powered());
}

TEST(DriveTraps, TheZeroOfAnOdriveThatWasNeverOnIsNoPosition) {
  DriveRig rig(Kind::kOdrive05);
  rig.drive(0).shaft.position_rad = 1;
  ASSERT_TRUE(rig.until_all(State::kIdle));
  EXPECT_FALSE(rig.states[0].position_known);
  ASSERT_EQ(rig.bus.enable(), "");
  ASSERT_TRUE(rig.until_all(State::kRunning)) << rig.text();
  EXPECT_TRUE(rig.states[0].position_known);
  EXPECT_NEAR(rig.states[0].position_rad, 1, 1e-2);
}

TEST(DriveTraps, AnOdriveOfTheOtherFirmwareIsRefused) {
  std::vector<DriveConfig> configs = {config_of(Kind::kOdrive05, 1)};
  auto ends = socket_pair();
  DriveBus bus(std::move(ends.first), configs, kPeriod_s);
  EmulatedBus emulated(std::move(ends.second));
  emulated.add(std::make_unique<EmulatedOdrive>(std::uint8_t{1}, true));
  DriveState state;
  for (std::uint64_t now_us = 1'000'000; now_us < 2'000'000; now_us += 1000) {
    bus.begin_cycle(now_us, {}, {});
    emulated.run(now_us);
    emulated.run(now_us + 300);
    state = bus.end_cycle(now_us + 300)[0];
  }
  EXPECT_EQ(state.fault, DriveFault::kVersion) << name_of(state.fault);
}

// Its samples are of the drive's clock: their age wanders, and that is no silence.
TEST(DriveTraps, TheAgeOfAnOdrivesEstimatesWanders) {
  DriveRig rig(Kind::kOdrive05);
  rig.drive<EmulatedOdrive>(0).config.clock_drift = 2e-3;
  ASSERT_TRUE(rig.start());
  float least = 1e9F, most = 0;
  for (int i = 0; i < 2000; ++i) {
    rig.tick();
    least = std::min(least, rig.states[0].age_us);
    most = std::max(most, rig.states[0].age_us);
  }
  EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  EXPECT_LE(least, 300);
  EXPECT_GE(most, 1000);
}

// MIT mode

TEST(DriveTraps, AMitReplyIsFromBeforeItsCommand) {
  Bench bench(std::make_unique<EmulatedMit>(EmulatedMit::Flavour::kMiniCheetah, std::uint16_t{1},
                                            std::uint16_t{17}, 30.0, 10.0));
  namespace mit = board::drives::mit;
  const mit::Ranges ranges = mit::ranges_of(12.5F, 30, 10);
  bench.send(mit::pack_magic(1, mit::Magic::kEnable, false));
  (void)bench.last();
  mit::Dither dither;
  const auto reported = [&](float torque) {
    bench.send(mit::pack(1, dither.codes({torque, 0}, ranges), false));
    const auto frame = bench.last();
    board::drives::Sample sample;
    EXPECT_EQ(mit::unpack(Kind::kMiniCheetah, 1, 17, ranges, 0, frame, sample).reply,
              board::drives::Reply::kMotion);
    bench.wait_us(3000);
    return sample.torque_N_m;
  };
  EXPECT_NEAR(reported(.5F), 0, .01);
  EXPECT_NEAR(reported(-.5F), .5, .01);
  EXPECT_NEAR(reported(0), -.5, .01);
}

// After its timeout a mini-cheetah goes on with the next frame, without a word.
TEST(DriveTraps, AMitDriveResumesWithoutAWordSoAGapIsLatchedHere) {
  DriveRig rig(Kind::kMiniCheetah);
  ASSERT_TRUE(rig.start());
  rig.torque_N_m = {.2F, .2F};
  rig.tick(10);
  rig.pause(20);  // shorter than its 25 ms: no gap
  rig.tick(5);
  EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  rig.pause(40);
  EXPECT_NEAR(rig.drive(0).torque_N_m(), 0, 1e-3);
  EXPECT_TRUE(rig.drive(0).powered());
  rig.tick(5);
  EXPECT_TRUE(rig.dropped(DriveFault::kHostGap));
  EXPECT_LT(std::abs(rig.drive(0).torque_N_m()), .06);
}

TEST(DriveTraps, NoMotionSetsTheZeroOfAMitDrive) {
  for (const Kind kind : {Kind::kMiniCheetah, Kind::kCubeMars, Kind::kDamiao}) {
    DriveRig rig(two(kind, [](DriveConfig& config) { config.peak_torque_N_m = 1e9F; }));
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = 1e9;
    rig.torque_N_m = {1e9F, -1e9F};
    rig.damping_N_m_s_rad = {1e9F, 1e9F};
    rig.tick(20);
    EXPECT_EQ(rig.drive<EmulatedMit>(0).zeroed(), 0U);
    EXPECT_NEAR(rig.drive(0).torque_N_m(), 10, .01);
  }
}

TEST(DriveTraps, ZeroTorqueThatCannotBeSentIsZeroInTheMean) {
  DriveRig rig(Kind::kDamiaoFd);
  ASSERT_TRUE(rig.start());
  rig.drive(0).shaft.inertia_kg_m2 = 1e6;
  double sum = 0, most = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.tick();
    sum += rig.drive(0).torque_N_m();
    most = std::max(most, std::abs(rig.drive(0).torque_N_m()));
  }
  EXPECT_NEAR(sum / 1000, 0, 2e-5);  // not -2.4 mN m
  EXPECT_GT(most, 1e-3);             // the codes are not zero
}

TEST(DriveTraps, AnOldReplyOfSixBytesIsRead) {
  DriveRig rig(Kind::kMiniCheetah);
  rig.drive<EmulatedMit>(0).old_reply = true;
  ASSERT_TRUE(rig.start());
  EXPECT_TRUE(std::isnan(rig.states[0].supply_V));
  EXPECT_NEAR(rig.states[1].supply_V, 24, .1);
}

TEST(DriveTraps, APositionThatIsNoNumberIsAWrongFrame) {
  for (const Kind kind : {Kind::kMoteus, Kind::kOdrive05, Kind::kOdrive06}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.tick();
    const double position = rig.states[0].position_rad;
    rig.drive(0).shaft.position_rad = std::nan("");
    rig.tick(3);
    EXPECT_TRUE(rig.dropped(DriveFault::kWrongFrame)) << name_of_kind(kind);
    EXPECT_NEAR(rig.states[0].position_rad, position, 1e-3);
  }
}

// The encoder. A frozen one looks like a joint at rest: the controller's encoder probe finds it, no reply does.
TEST(DriveTraps, AFrozenEncoderIsNotSeenHereANoisyOneIsNoFaultAndAJumpIs) {
  DriveRig frozen(Kind::kMoteus);
  ASSERT_TRUE(frozen.start());
  frozen.drive(0).inject.encoder_frozen = true;
  frozen.torque_N_m = {.1F, 0};
  frozen.tick(100);
  EXPECT_TRUE(frozen.all(State::kRunning));
  DriveRig noisy(Kind::kMoteus);
  ASSERT_TRUE(noisy.start());
  noisy.drive(0).inject.encoder_noise_rad = .01;
  noisy.tick(500);
  EXPECT_TRUE(noisy.all(State::kRunning)) << noisy.text();
  for (const Kind kind : kKinds) {
    DriveRig jumping(kind);
    ASSERT_TRUE(jumping.start());
    jumping.drive(0).inject.encoder_jump_rad = 2 * std::numbers::pi;
    jumping.tick(3);
    EXPECT_TRUE(jumping.dropped(DriveFault::kPositionJump)) << name_of_kind(kind);
    if (is_odrive(kind)) continue;  // without a position while it is off
    DriveRig idle(kind);
    ASSERT_TRUE(idle.until_all(State::kIdle));
    idle.drive(0).inject.encoder_jump_rad = 2 * std::numbers::pi;
    idle.tick(3);
    EXPECT_TRUE(idle.dropped(DriveFault::kPositionJump)) << name_of_kind(kind);
  }
}

TEST(DriveTraps, TorqueIsLimitedToThePeakAndNoNumberIsNoTorque) {
  for (const Kind kind : kKinds) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.start());
    rig.drive(0).shaft.inertia_kg_m2 = rig.drive(1).shaft.inertia_kg_m2 = 1e9;
    rig.torque_N_m = {50, std::nanf("")};
    rig.damping_N_m_s_rad = {std::nanf(""), std::nanf("")};
    rig.tick(30);
    EXPECT_NEAR(rig.drive(0).torque_N_m(), 1, .01) << name_of_kind(kind);
    EXPECT_NEAR(rig.drive(1).torque_N_m(), 0, .004) << name_of_kind(kind);
  }
}

}  // namespace
}  // namespace thimble::test
