// The modes: every command and every safety input in every mode, and every condition that stands against
// arming.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

enum class Event { kHome, kArm, kDisarm, kClear, kStop, kDeadManReleased, kEStop, kNothing };
constexpr const char* kEventNames[] = {"home",   "arm",    "disarm", "clear", "stop", "dead_man_released",
                                       "e_stop", "nothing"};

// A bench in each mode. Arms have an index, so that homing lasts.
std::unique_ptr<Bench> bench_in(Mode mode) {
  firmware::Config config;
  config.arm[0].has_index = true;
  auto bench = std::make_unique<Bench>(config);
  bench->load();
  bench->tick();
  if (mode == Mode::kDisarmed) return bench;
  EXPECT_EQ(bench->controller->request(Command::kHome), 0);
  bench->tick();
  if (mode == Mode::kHoming) return bench;
  bench->inputs.arm[0].index = true;
  bench->tick();
  bench->inputs.arm[0].index = false;
  if (mode == Mode::kReady) return bench;
  bench->arm();
  if (mode == Mode::kArmed) return bench;
  if (mode == Mode::kDamping) {
    EXPECT_EQ(bench->controller->request(Command::kDisarm), 0);
    bench->tick();
    return bench;
  }
  EXPECT_EQ(bench->controller->request(Command::kStop), 0);
  bench->ticks(2000);
  return bench;
}

Mode after(Mode mode, Event event) {
  const auto bench = bench_in(mode);
  EXPECT_EQ(bench->mode(), mode);
  constexpr Command kCommands[] = {Command::kHome, Command::kArm, Command::kDisarm, Command::kClear,
                                   Command::kStop};
  if (event <= Event::kStop) (void)bench->controller->request(kCommands[static_cast<int>(event)]);
  if (event == Event::kDeadManReleased) bench->inputs.dead_man = false;
  if (event == Event::kEStop) bench->inputs.e_stop = true;
  bench->tick();
  EXPECT_EQ(bench->outputs.mode, bench->mode());
  EXPECT_EQ(any_enabled(bench->outputs), bench->mode() == Mode::kArmed || bench->mode() == Mode::kDamping);
  return bench->mode();
}

TEST(Modes, EveryEventInEveryMode) {
  constexpr Mode kD = Mode::kDisarmed, kH = Mode::kHoming, kR = Mode::kReady, kA = Mode::kArmed,
                 kB = Mode::kDamping, kF = Mode::kFaulted;
  struct Row {
    Mode mode;
    Mode next[8];
  };
  // home arm disarm clear stop dead-man e-stop nothing
  constexpr Row kTable[] = {
      {kD, {kH, kD, kD, kD, kF, kD, kF, kD}}, {kH, {kH, kH, kD, kH, kF, kH, kF, kH}},
      {kR, {kH, kA, kR, kR, kF, kR, kF, kR}}, {kA, {kA, kA, kB, kA, kB, kB, kB, kA}},
      {kB, {kB, kB, kB, kB, kB, kB, kB, kB}}, {kF, {kF, kF, kF, kR, kF, kF, kF, kF}},
  };
  int checked = 0;
  for (const Row& row : kTable) {
    for (int event = 0; event < 8; ++event) {
      EXPECT_EQ(name(after(row.mode, static_cast<Event>(event))), std::string(name(row.next[event])))
          << name(row.mode) << " + " << kEventNames[event];
      ++checked;
    }
  }
  std::printf("transitions checked: %d\n", checked);
}

link::StoppedBy stopped_by(Bench& bench) {
  link::DeviceState state;
  EXPECT_TRUE(link::decode(Tester(bench).read(link::DeviceState::kId), state));
  return state.stopped_by;
}

// All that can end arming in one tick, in every combination; and nothing that comes later changes the reason.
TEST(StoppedBy, OfSeveralInOneTickTheFirstOfFaultDisarmAndSwitch) {
  using link::StoppedBy;
  EXPECT_EQ(stopped_by(*bench_in(Mode::kDisarmed)), StoppedBy::kNothing);
  EXPECT_EQ(stopped_by(*bench_in(Mode::kArmed)), StoppedBy::kNothing);
  for (unsigned all = 1; all < 32; ++all) {
    const auto has = [all](unsigned bit) { return (all >> bit & 1U) != 0; };
    const auto bench = bench_in(Mode::kArmed);
    if (has(0)) bench->inputs.dead_man = false;
    if (has(1)) (void)bench->controller->request(Command::kDisarm);
    if (has(2)) (void)bench->controller->request(Command::kStop);
    bench->inputs.e_stop = has(3);
    bench->inputs.arm[0].drive_fault = has(4);
    bench->tick();
    // The fault that latched tells whether a stop or a fault was first.
    const Fault latched = bench->controller->fault();
    EXPECT_EQ(latched, has(3)   ? Fault::e_stop
                       : has(2) ? Fault::host_stop
                       : has(4) ? Fault::drive_fault
                                : Fault::kNone);
    const StoppedBy expected = latched == Fault::host_stop ? StoppedBy::kStop
                               : latched != Fault::kNone   ? StoppedBy::kFault
                               : has(1)                    ? StoppedBy::kDisarm
                                                           : StoppedBy::kDeadMan;
    EXPECT_EQ(stopped_by(*bench), expected) << all;
    bench->inputs.dead_man = false;
    (void)bench->controller->request(Command::kDisarm);
    (void)bench->controller->request(Command::kStop);
    bench->ticks(1100);
    EXPECT_EQ(stopped_by(*bench), expected) << all << ", later";
  }
}

// Kept while it is armed again, until that ends too.
TEST(StoppedBy, IsOfTheLastTime) {
  using link::StoppedBy;
  Bench bench;
  bench.start();
  bench.inputs.dead_man = false;
  bench.ticks(1100);
  EXPECT_EQ(stopped_by(bench), StoppedBy::kDeadMan);
  bench.inputs.dead_man = true;
  bench.tick();
  bench.arm();
  EXPECT_EQ(stopped_by(bench), StoppedBy::kDeadMan);
  EXPECT_EQ(bench.controller->request(Command::kDisarm), 0);
  bench.tick();
  EXPECT_EQ(stopped_by(bench), StoppedBy::kDisarm);
  bench.restart("host");
  EXPECT_EQ(stopped_by(bench), StoppedBy::kNothing);
}

TEST(Modes, DampingEndsInReadyOrFaulted) {
  const auto disarmed = bench_in(Mode::kArmed);
  EXPECT_EQ(disarmed->controller->request(Command::kDisarm), 0);
  int ticks = 0;
  do {
    disarmed->tick();
    ++ticks;
  } while (disarmed->mode() == Mode::kDamping && ticks < 4000);
  EXPECT_EQ(disarmed->mode(), Mode::kReady);
  std::printf("damping lasted %d ticks (0.25 s is 1000)\n", ticks);
  EXPECT_NEAR(ticks, 1000, 2);

  const auto tripped = bench_in(Mode::kArmed);
  EXPECT_EQ(tripped->controller->request(Command::kStop), 0);
  tripped->ticks(1100);
  EXPECT_EQ(tripped->mode(), Mode::kFaulted);
}

TEST(Modes, DampingBrakesTheTip) {
  Bench bench;
  bench.load(1000.0F, -1.0F);  // out of reach: free space
  bench.home();
  bench.arm();
  bench.move({0.02, 0, 0.02}, 200);
  EXPECT_EQ(bench.controller->request(Command::kDisarm), 0);
  bench.move({0.03, 0, 0.02}, 200);  // 0.2 m/s to the right
  ASSERT_EQ(bench.mode(), Mode::kDamping);
  const Vec3 force_N = bench.shown().arm[0].force_N;
  std::printf("damping force at 0.2 m/s: %.3f %.3f %.3f N (2 N s/m asks for -0.4)\n",
              static_cast<double>(force_N.x()), static_cast<double>(force_N.y()),
              static_cast<double>(force_N.z()));
  EXPECT_NEAR(force_N.x(), -0.4F, 0.05F);
}

// The one unmet condition is named in the refusal; with it met again, arming works.
struct ArmingCase {
  firmware::Condition condition;
  void (*spoil)(Bench&);
  void (*mend)(Bench&);
};

const ArmingCase kArmingCases[] = {
    {firmware::kEncoderStale, [](Bench& b) { b.sampling = false; }, nullptr},
    {firmware::kOutsideWorkspace,
     [](Bench& b) {
       for (int i = 0; i < 1000; ++i) {
         b.joints[0][0] += 1.7 / 1000;  // the turntable beyond 90 degrees
         b.tick();
       }
     },
     [](Bench& b) {
       for (int i = 0; i < 1000; ++i) {
         b.joints[0][0] -= 1.7 / 1000;
         b.tick();
       }
     }},
    {firmware::kDeadManOpen, [](Bench& b) { b.inputs.dead_man = false; },
     [](Bench& b) { b.inputs.dead_man = true; }},
    {firmware::kLinkDown,
     [](Bench& b) {
       b.alive = false;
       b.ticks(4100);
     },
     [](Bench& b) { b.alive = true; }},
    {firmware::kEStopPressed, [](Bench& b) { b.inputs.e_stop = true; },
     [](Bench& b) {
       b.inputs.e_stop = false;
       b.tick();
       EXPECT_EQ(b.controller->request(Command::kClear), 0);
     }},
    {firmware::kDriveFault, [](Bench& b) { b.inputs.arm[0].drive_fault = true; },
     [](Bench& b) {
       b.inputs.arm[0].drive_fault = false;
       b.tick();
       EXPECT_EQ(b.controller->request(Command::kClear), 0);
     }},
    {firmware::kFaultLatched, [](Bench& b) { (void)b.controller->request(Command::kStop); },
     [](Bench& b) { EXPECT_EQ(b.controller->request(Command::kClear), 0); }},
    {firmware::kWrongMode,
     [](Bench& b) {
       b.arm();
       b.ticks(10);
       (void)b.controller->request(Command::kDisarm);
     },
     [](Bench& b) { b.ticks(1100); }},
};

// No tick has to come between the two.
TEST(Arming, ASignOfLifeCountsAtOnce) {
  Bench bench;
  bench.load();
  bench.home();
  bench.alive = false;
  bench.ticks(4100);
  EXPECT_EQ(bench.controller->request(Command::kArm), firmware::kLinkDown);
  bench.controller->keep_alive();
  bench.arm();
}

TEST(Arming, EveryUnmetConditionIsNamed) {
  for (const ArmingCase& c : kArmingCases) {
    Bench bench;
    bench.load();
    bench.home();
    ASSERT_EQ(bench.controller->unmet(), 0);
    c.spoil(bench);
    bench.ticks(5);
    const Conditions refused = bench.controller->request(Command::kArm);
    EXPECT_NE(refused & c.condition, 0) << "condition " << c.condition << ", refused with " << refused;
    bench.tick();
    EXPECT_NE(bench.mode(), Mode::kArmed);
    if (c.mend == nullptr) continue;
    c.mend(bench);
    bench.ticks(2);
    EXPECT_EQ(bench.controller->request(Command::kArm), 0) << "condition " << c.condition;
    bench.tick();
    EXPECT_EQ(bench.mode(), Mode::kArmed) << "condition " << c.condition;
  }

  Bench nothing;  // not homed, no scene
  nothing.tick();
  EXPECT_EQ(nothing.controller->request(Command::kArm), firmware::kNotHomed | firmware::kNoScene);

  firmware::Config config;
  config.arm_count = 3;
  Bench wrong(config);
  EXPECT_NE(wrong.controller->request(Command::kArm) & firmware::kBadConfig, 0);

  for (const auto& row : firmware::kConditionTable) std::printf("%s: %s\n", row.name, row.remedy);
}

// The tick checks again: what was true when the command was posted may not be true when it is obeyed.
TEST(Arming, IsCheckedAgainInTheTick) {
  Bench bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->request(Command::kArm), 0);
  bench.inputs.dead_man = false;
  bench.tick();
  EXPECT_EQ(bench.mode(), Mode::kReady);
  bench.inputs.dead_man = true;
  bench.ticks(10);
  EXPECT_EQ(bench.mode(), Mode::kReady) << "the command must not be kept for later";
}

TEST(Arming, TwoArmsEachWithAModelAndBase) {
  firmware::Config config;
  config.arm_count = 2;
  config.arm[1].model = "wooden";
  config.arm[1].base.home_m = {0.3F, 0, 0.1F};
  Bench bench(config);
  bench.start();
  EXPECT_NEAR(bench.shown().arm[0].tip_m.x(), 0.0F, 1e-4F);
  EXPECT_NEAR(bench.shown().arm[1].tip_m.x(), 0.3F, 1e-4F);
  EXPECT_NEAR(bench.shown().arm[1].tip_m.z(), 0.1F, 1e-4F);
  EXPECT_TRUE(bench.outputs.arm[0].enable && bench.outputs.arm[1].enable);
  bench.inputs.arm[1].drive_fault = true;
  bench.tick();
  EXPECT_FALSE(any_enabled(bench.outputs)) << "a fault of one arm stops both";
}

TEST(Homing, TakesTheIndexNotTheMoment) {
  firmware::Config config;
  config.arm[0].has_index = true;
  Bench bench(config);
  bench.load();
  bench.joints[0] = {0.2, 0.1, -0.1};  // powered on somewhere else
  bench.tick();
  EXPECT_EQ(bench.controller->request(Command::kHome), 0);
  bench.ticks(100);
  EXPECT_EQ(bench.mode(), Mode::kHoming);
  for (int i = 0; i < 200; ++i) {
    bench.joints[0] *= 0.95;
    bench.tick();
  }
  bench.joints[0].setZero();
  bench.inputs.arm[0].index = true;
  bench.tick();
  EXPECT_EQ(bench.mode(), Mode::kReady);
  std::printf("tip after homing: %.6f m from home\n", static_cast<double>(bench.shown().arm[0].tip_m.norm()));
  EXPECT_LT(bench.shown().arm[0].tip_m.norm(), 1e-4F);
}

}  // namespace
}  // namespace thimble::test
