// The life of the drives of a bus against emulated ones: start, run, stop, and each fault by name.
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include <cmath>
#include <functional>
#include <map>

#include "tests/support/no_heap_guard.h"
#include "tests/unit/drives/rig.h"

namespace thimble::test {
namespace {

class EveryKind : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Drives, EveryKind, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return name_of_kind(kind.param); });

TEST_P(EveryKind, StartsRunsAndStops) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.until_all(State::kIdle)) << rig.text();
  EXPECT_EQ(rig.torque_N_m.size(), 2U);
  rig.torque_N_m = {.1F, -.1F};  // before it runs: no torque
  rig.tick(30);
  EXPECT_TRUE(rig.all(State::kIdle));
  EXPECT_FALSE(rig.drive(0).powered());
  ASSERT_EQ(rig.bus.enable(), "");
  rig.tick(15);
  EXPECT_TRUE(rig.all(State::kEnabled)) << rig.text();
  EXPECT_NEAR(rig.drive(0).torque_N_m(), 0, 5e-3);
  ASSERT_TRUE(rig.until_all(State::kRunning)) << rig.text();
  rig.tick(8);
  EXPECT_NEAR(rig.drive(0).torque_N_m(), .1, .012) << "of the torque, part is damping";
  EXPECT_NEAR(rig.drive(1).torque_N_m(), -.1, .012);
  EXPECT_TRUE(rig.states[0].fresh || is_odrive(GetParam()));
  EXPECT_LT(rig.states[0].age_us, 1400);
  rig.bus.disable();
  rig.tick(20);
  EXPECT_TRUE(rig.all(State::kBraking));
  EXPECT_LE(rig.drive(0).torque_N_m(), 5e-3);
  ASSERT_TRUE(rig.until_all(State::kIdle, 400)) << rig.text();
  rig.tick(3);
  EXPECT_FALSE(rig.drive(0).powered());
  EXPECT_EQ(rig.states[0].fault, DriveFault::kNone);
}

// As after power-on, when the board needs longer than the drives: a watchdog that is on has run out by then.
TEST_P(EveryKind, ADriveThatHadPowerBeforeItsHostStarts) {
  DriveRig rig(GetParam());
  rig.pause(2000);
  EXPECT_TRUE(rig.start()) << rig.text();
  EXPECT_EQ(rig.states[0].fault, DriveFault::kNone);
}

TEST_P(EveryKind, ReportsPositionAndVelocityInRadians) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  const double begin = rig.states[0].position_rad;
  rig.drive(0).shaft.position_rad = rig.drive(0).shaft.position_rad;
  rig.drive(0).shaft.inertia_kg_m2 = 1e6;  // moves on as it is
  rig.drive(0).shaft.velocity_rad_s = 2 * std::numbers::pi;
  const double from = rig.drive(0).shaft.position_rad;
  rig.tick(1000);
  const double moved = rig.drive(0).shaft.position_rad - from;
  EXPECT_NEAR(moved, 2 * std::numbers::pi, 1e-2);
  EXPECT_NEAR(rig.states[0].position_rad - begin, moved, 2e-2);
  EXPECT_NEAR(rig.states[0].velocity_rad_s, 2 * std::numbers::pi, .02);
}

TEST_P(EveryKind, OneLostReplyIsNotTakenForFreshAndThreeAreSilence) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.drive(0).inject.drop_replies = 1;
  rig.tick(4);
  EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
  rig.drive(0).inject.drop_replies = 1000;
  rig.tick(1);
  EXPECT_FALSE(rig.states[0].fresh);
  rig.tick(3);
  EXPECT_TRUE(rig.dropped(DriveFault::kSilent));
  EXPECT_EQ(rig.states[0].state, State::kSilent);
  EXPECT_EQ(rig.states[1].state, State::kBraking);
  rig.tick(600);
  EXPECT_FALSE(rig.drive(0).powered());
  EXPECT_FALSE(rig.drive(1).powered());
}

// An ODrive tells its position on its own timer: what comes just behind the end of a tick is of the next one. Where each tick without
// one began the 20 ticks anew, two drives came on late, and a servo that pushed meanwhile looked like a dead encoder.
TEST(DriveTimer, APositionThatComesATickLaterHoldsNothingUp) {
  for (const Kind kind : {Kind::kOdrive05, Kind::kOdrive06}) {
    DriveRig rig(kind);
    ASSERT_TRUE(rig.until_all(State::kIdle)) << rig.text();
    ASSERT_EQ(rig.bus.enable(), "");
    unsigned ticks = 0;
    for (; ticks < 2000 && !rig.all(State::kRunning); ++ticks) {
      if (ticks % 10 == 0) rig.drive(ticks / 10 % 2).inject.drop_replies = 1;
      rig.tick();
    }
    EXPECT_TRUE(rig.all(State::kRunning)) << rig.text();
    EXPECT_LT(ticks, 250) << "a heartbeat takes 100";
  }
}

TEST_P(EveryKind, AfterAFaultNothingIsEnabledButByCommand) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.torque_N_m = {.1F, .1F};
  rig.drive(0).inject.drop_replies = 40;
  rig.tick(2000);
  EXPECT_EQ(rig.states[0].state, State::kSilent) << rig.text();
  EXPECT_EQ(rig.states[1].state, State::kIdle);
  EXPECT_FALSE(rig.drive(0).powered());
  EXPECT_EQ(rig.bus.enable(), "a drive is not idle");
  rig.bus.clear();
  ASSERT_TRUE(rig.until_all(State::kIdle)) << rig.text();
  rig.tick(500);
  EXPECT_TRUE(rig.all(State::kIdle)) << "and no farther";
  rig.torque_N_m = {0, 0};
  EXPECT_TRUE(rig.start());
}

// Turns that were counted and torques that differed belong to the life before.
TEST(DriveClear, ForgetsWhatWasBefore) {
  DriveRig rig(Kind::kDamiaoFd);
  ASSERT_TRUE(rig.start());
  rig.drive(0).shaft.inertia_kg_m2 = 1e6;
  rig.drive(0).shaft.velocity_rad_s = 20;
  rig.tick(700);
  EXPECT_NEAR(rig.states[0].position_rad, 14, .1);
  rig.drive(0).shaft.velocity_rad_s = 0;
  rig.drive(0).inject.current_factor = .5;
  rig.torque_N_m = {.5F, 0};
  rig.tick(150);
  EXPECT_EQ(rig.states[0].limiter, Limiter::kUnseen);
  rig.drive(0).inject.mute = true;
  rig.tick(700);
  ASSERT_EQ(rig.states[0].state, State::kSilent);
  rig.drive(0).inject = {};
  rig.bus.clear();
  ASSERT_TRUE(rig.until_all(State::kIdle)) << rig.text();
  EXPECT_NEAR(rig.states[0].position_rad, 14 - 25, .1);
  ASSERT_EQ(rig.bus.enable(), "");
  rig.tick(1);
  EXPECT_EQ(rig.states[0].state, State::kEnabled);
  EXPECT_EQ(rig.states[0].limiter, Limiter::kNone);
}

TEST(DriveClear, DoesNothingToADriveThatStillBrakes) {
  DriveRig rig(Kind::kMoteus);
  ASSERT_TRUE(rig.start());
  rig.drive(0).inject.repeat_replies = 10;
  rig.tick(5);
  ASSERT_EQ(rig.states[0].state, State::kBraking) << rig.text();
  rig.bus.clear();
  EXPECT_EQ(rig.bus.end_cycle(rig.now_us)[0].fault, DriveFault::kTwoReplies);
  EXPECT_EQ(rig.bus.end_cycle(rig.now_us)[0].supply_V, 24);
}

// It was cleared before it was told to switch off.
TEST_P(EveryKind, ADriveThatIsStillOnWhenItIsFoundIsSwitchedOff) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.drive(0).inject.drop_replies = 8;
  rig.tick(6);
  ASSERT_EQ(rig.states[0].state, State::kSilent);
  EXPECT_TRUE(rig.drive(0).powered());
  rig.bus.clear();
  rig.tick(12);
  EXPECT_FALSE(rig.drive(0).powered()) << rig.text();
}

// 300 ms of torque 0 and base damping, then off.
TEST_P(EveryKind, AFaultOfOneBrakesTheOthers) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  rig.torque_N_m = {.2F, .2F};
  rig.tick(10);
  rig.drive(0).inject.mute = true;
  rig.tick(6);
  ASSERT_EQ(rig.states[1].state, State::kBraking) << rig.text();
  rig.tick(30);
  const double speed = rig.drive(1).shaft.velocity_rad_s;
  EXPECT_GT(speed, .5);
  rig.tick(100);  // (.005 + .001) N m s/rad on 1 g m2: e^-0.6 in 100 ms
  EXPECT_NEAR(rig.drive(1).shaft.velocity_rad_s, speed * std::exp(-.6), .04 * speed);
  rig.tick(150);
  EXPECT_EQ(rig.states[1].state, State::kBraking);  // for 286 ms
  rig.tick(40);
  EXPECT_FALSE(rig.drive(1).powered());
  EXPECT_EQ(rig.states[1].state, State::kIdle);
}

// The bus time that is computed is that of the frames of a tick. Heartbeats and currents, every 10 ms and less often, are not counted.
TEST(BusTimeOfATick, IsThatOfItsFrames) {
  std::vector<DriveConfig> configs;
  for (const Kind kind : kKinds) configs.push_back(config_of(kind, 1));
  configs.push_back(config_of(Kind::kMoteus, 1));
  configs.back().short_frames = true;
  configs.push_back(config_of(Kind::kOdrive05, 1));
  configs.back().base_damping_N_m_s_rad = 0;
  configs.push_back(config_of(Kind::kOdrive05, 1));
  configs.back().request_estimates = true;
  configs.back().reply_period_s = 0;
  for (const DriveConfig& config : configs) {
    DriveRig rig({config});
    ASSERT_TRUE(rig.start()) << name_of_kind(config.kind);
    std::vector<board::drives::CanFrame> frames;
    rig.emulated.tap = &frames;
    rig.tick(1000);
    rig.emulated.tap = nullptr;
    double time_us = 0;
    for (const auto& frame : frames) {
      const bool cyclic = frame.id == 0x21 || frame.id == 0x34 || frame.id == 0x3C;
      if (!is_odrive(config.kind) || !cyclic)
        time_us += static_cast<double>(board::drives::frame_time_us(frame.size, frame.fd, frame.extended));
    }
    // Telemetry every tenth tick adds a tenth of the difference to the short form.
    const double expected = static_cast<double>(board::drives::exchange_time_us(exchange_of(config)));
    EXPECT_NEAR(time_us / 1000, expected, config.short_frames ? 6 : 1) << name_of_kind(config.kind);
  }
}

TEST_P(EveryKind, ACycleUsesNoHeap) {
  DriveRig rig(GetParam());
  ASSERT_TRUE(rig.start());
  for (unsigned i = 0; i < 100; ++i) {
    if (i == 50) rig.drive(0).inject.drop_replies = 30;  // through a fault too
    {
      const NoHeapGuard guard;
      rig.bus.begin_cycle(rig.now_us, rig.torque_N_m, rig.damping_N_m_s_rad);
    }
    rig.emulated.run(rig.now_us);
    rig.emulated.run(rig.now_us + 300);
    {
      const NoHeapGuard guard;
      (void)rig.bus.end_cycle(rig.now_us + 300);
    }
    rig.now_us += 1000;
  }
}

TEST_P(EveryKind, RandomFramesNeverEnableAnything) {
  DriveRig rig(GetParam());
  rig.emulation_stopped = true;
  std::mt19937 random(5);
  for (int i = 0; i < 3000; ++i) {
    for (int j = 0; j < 4; ++j) {
      board::drives::CanFrame frame;
      static constexpr std::uint32_t kIds[] = {0x100, 0x200, 0x11, 0x12, 0x20, 0x21, 0x29, 0x49, 0x34, 0x5C};
      frame.id = kIds[random() % 10];
      frame.fd = random() % 2 == 0;
      frame.size =
          frame.fd ? firmware::link::fd_size(random() % 65) : static_cast<std::uint8_t>(random() % 9);
      for (std::uint8_t& byte : frame.data)
        byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() % 64 : random());
      rig.emulated.send(frame);
    }
    rig.tick();
    for (const DriveState& one : rig.states) {
      ASSERT_NE(one.state, State::kRunning);
      ASSERT_NE(one.state, State::kEnabled);
    }
    if (i % 100 == 0) rig.bus.clear();
  }
}

// Each fault, and what brings it about. Every row of drive_faults.def has one.
struct Injector {
  DriveFault fault;
  Kind kind;
  bool while_running;
  std::function<void(DriveRig&)> inject;
  unsigned ticks = 400;
};

void start_outside(DriveRig& rig) { rig.drive(0).shaft.position_rad = 3; }

const std::vector<Injector>& injectors() {
  static const std::vector<Injector> kAll = {
      {DriveFault::kSilent, Kind::kDamiaoFd, true, [](DriveRig& rig) { rig.drive(0).inject.mute = true; }},
      {DriveFault::kStale, Kind::kMoteus, true,
       [](DriveRig& rig) { rig.drive(0).inject.clock_stands = true; }},
      {DriveFault::kDriveReported, Kind::kMoteus, true, [](DriveRig& rig) { rig.drive(0).fail(34); }},
      {DriveFault::kWatchdogExpired, Kind::kMoteus, true,
       [](DriveRig& rig) {
         for (unsigned i = 0; i < 17; ++i)
           rig.emulated.run(rig.now_us + 1000 * i);  // the drive's clock is faster
       }},
      {DriveFault::kWatchdogUnproven, Kind::kOdrive05, false,
       [](DriveRig& rig) { rig.drive<EmulatedOdrive>(0).config.watchdog = false; }, 1500},
      {DriveFault::kHostGap, Kind::kMiniCheetah, true, [](DriveRig& rig) { rig.pause(30); }},
      {DriveFault::kRebooted, Kind::kMoteus, true, [](DriveRig& rig) { rig.drive(0).reboot(); }},
      {DriveFault::kPositionJump, Kind::kDamiao, true,
       [](DriveRig& rig) { rig.drive(0).inject.encoder_jump_rad = 6.2832; }},
      {DriveFault::kTorqueDiffers, Kind::kMoteus, true,
       [](DriveRig& rig) {
         rig.drive(0).inject.most_torque_N_m = .1;
         rig.drive(0).shaft.inertia_kg_m2 = 1;
         rig.torque_N_m = {.3F, 0};
       }},
      {DriveFault::kConfigDiffers, Kind::kDamiao, false,
       [](DriveRig& rig) { rig.drive<EmulatedMit>(0).registers[23] = std::bit_cast<std::uint32_t>(28.0F); }},
      {DriveFault::kConfigSilent, Kind::kOdrive06, false,
       [](DriveRig& rig) { rig.drive<EmulatedOdrive>(0).endpoints.erase(101); }},
      {DriveFault::kVersion, Kind::kOdrive06, false,
       [](DriveRig& rig) { rig.drive<EmulatedOdrive>(0).config.minor = 5; }},
      {DriveFault::kNotHomed, Kind::kMoteus, false,
       [](DriveRig& rig) { rig.drive<EmulatedMoteus>(0).home_state = 0; }},
      {DriveFault::kStartPose, Kind::kDamiao, false, start_outside},
      {DriveFault::kMoving, Kind::kMoteus, false,
       [](DriveRig& rig) {
         ASSERT_TRUE(rig.until_all(State::kIdle));
         rig.drive(0).shaft.inertia_kg_m2 = 1e6;
         rig.drive(0).shaft.velocity_rad_s = 3;
         ASSERT_EQ(rig.bus.enable(), "");
       },
       2500},
      {DriveFault::kNotEnabled, Kind::kOdrive05, false,
       [](DriveRig& rig) {
         ASSERT_TRUE(rig.until_all(State::kIdle));
         rig.drive<EmulatedOdrive>(0).stays_off = true;
         ASSERT_EQ(rig.bus.enable(), "");
       },
       2500},
      {DriveFault::kSwitchedOff, Kind::kDamiao, true, [](DriveRig& rig) { rig.bus.stop(true); }},
      {DriveFault::kWrongFrame, Kind::kDamiaoFd, false,
       [](DriveRig& rig) { rig.drive(0).inject.answer_classic = true; }},
      {DriveFault::kRejected, Kind::kMoteus, true,
       [](DriveRig& rig) { rig.drive<EmulatedMoteus>(0).refuses_register = 0x27; }},
      {DriveFault::kTwoReplies, Kind::kMoteus, true,
       [](DriveRig& rig) { rig.drive(0).inject.repeat_replies = 10; }},
      {DriveFault::kBusFull, Kind::kDamiao, true,
       [](DriveRig& rig) {
         rig.emulation_stopped = true;
         const can_frame filler{};
         while (send(rig.bus.descriptor(), &filler, sizeof(filler), MSG_DONTWAIT) > 0) {
         }
       }},
      {DriveFault::kBusOff, Kind::kDamiao, true,
       [](DriveRig& rig) {
         can_frame error{};
         error.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
         error.can_dlc = CAN_ERR_DLC;
         rig.emulated.send_raw(std::as_bytes(std::span(&error, 1)));
       }},
  };
  return kAll;
}

std::vector<DriveConfig> configs_for(const Injector& injector) {
  std::vector<DriveConfig> configs = {config_of(injector.kind, 1), config_of(injector.kind, 2)};
  if (injector.fault == DriveFault::kNotHomed) configs[0].needed_home_state = 1;
  if (injector.fault == DriveFault::kStartPose) configs[0].start_hi_rad = 2;
  return configs;
}

TEST(DriveFaults, EveryRowHasAnInjectorAndNothingElseIsReported) {
  for (const Injector& injector : injectors()) {
    SCOPED_TRACE(name_of(injector.fault));
    DriveRig rig(configs_for(injector));
    if (injector.while_running) {
      ASSERT_TRUE(rig.start());
    }
    injector.inject(rig);
    for (unsigned i = 0;
         i < injector.ticks && (rig.states.empty() || rig.states[0].fault == DriveFault::kNone); ++i)
      rig.tick();
    EXPECT_TRUE(rig.dropped(injector.fault));
    EXPECT_STRNE(sentence_of(injector.fault), "");
  }
  const auto has = [](DriveFault fault) {
    return std::ranges::any_of(injectors(), [fault](const Injector& one) { return one.fault == fault; });
  };
#define DRIVE_FAULT(enumerator, name, sentence) EXPECT_TRUE(has(DriveFault::enumerator)) << (name);
#include "board/linux/drives/drive_faults.def"
#undef DRIVE_FAULT
}

TEST(DriveFaults, WithoutAnInjectionThereIsNone) {
  for (const Injector& injector : injectors()) {
    DriveRig rig(configs_for(injector));
    ASSERT_TRUE(rig.start()) << name_of(injector.fault);
    rig.torque_N_m = {.05F, -.05F};
    rig.tick(500);
    EXPECT_TRUE(rig.all(State::kRunning)) << name_of(injector.fault) << ' ' << rig.text();
    EXPECT_EQ(rig.states[0].late_replies, 0U);
  }
}

TEST(DriveConfigs, AreRefusedWithASentence) {
  using board::drives::check_drives;
  const auto wrong = [](std::vector<DriveConfig> configs) { return check_drives(configs, kPeriod_s); };
  EXPECT_EQ(wrong({config_of(Kind::kMoteus, 1), config_of(Kind::kMoteus, 2), config_of(Kind::kDamiao, 1)}),
            "");
  EXPECT_EQ(wrong({config_of(Kind::kMoteus, 1), config_of(Kind::kMoteus, 1)}),
            "two drives of one bus have the same id or reply id");
  std::vector<DriveConfig> nine;
  for (std::uint8_t id = 1; id <= 9; ++id) nine.push_back(config_of(Kind::kMoteus, id));
  EXPECT_EQ(wrong(nine), "a bus has at most eight drives");
  DriveConfig config = config_of(Kind::kMiniCheetah, 1);
  config.reply_id = 0;
  EXPECT_NE(wrong({config}), "");
  config = config_of(Kind::kDamiao, 1);
  config.watchdog_s = 0;
  EXPECT_EQ(wrong({config}), "the drive's watchdog must be 10 to 20 ticks");
  config.watchdog_s = .1F;
  EXPECT_EQ(wrong({config}), "the drive's watchdog must be 10 to 20 ticks");
  config = config_of(Kind::kMoteus, 1);
  config.moteus_timeout_mode = 0;
  EXPECT_EQ(wrong({config}), "a moteus must brake when the host is silent: servo.timeout_mode 12 or 15");
  config = config_of(Kind::kOdrive06, 63);
  EXPECT_NE(wrong({config}), "");
  config.id = 3;
  config.items = {};
  EXPECT_NE(wrong({config}), "");
}

TEST(DriveConfigs, TheHashIsOfWhatWasReadBack) {
  DriveRig rig(Kind::kDamiao);
  ASSERT_TRUE(rig.until_all(State::kIdle));
  EXPECT_EQ(rig.states[0].config_hash, rig.states[1].config_hash);
  EXPECT_NE(rig.states[0].config_hash, 0U);
  DriveRig other({config_of(Kind::kDamiao, 1), [] {
                    DriveConfig config = config_of(Kind::kDamiao, 2);
                    config.watchdog_s = .016F;
                    return config;
                  }()});
  other.drive<EmulatedMit>(1).registers[9] = 320;
  ASSERT_TRUE(other.until_all(State::kIdle)) << other.text();
  EXPECT_NE(other.states[0].config_hash, other.states[1].config_hash);
}

}  // namespace
}  // namespace thimble::test
