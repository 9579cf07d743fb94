// A disarm is obeyed by the next tick, whatever else is asked for before or after it, by whomever, and its answer comes after that tick.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "firmware/services/refusal.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

bool moves(Mode mode) { return mode == Mode::kArmed || mode == Mode::kHoming; }

TEST(Disarm, IsObeyedWhateverIsAskedForBeforeOrAfterIt) {
  constexpr std::array kOthers = {Command::kHome,   Command::kArm,     Command::kClear,
                                  Command::kRecord, Command::kEndMove, Command::kDisarm};
  for (const Command other : kOthers) {
    for (const bool before : {false, true}) {
      Bench bench;
      bench.start();
      if (before) static_cast<void>(bench.controller->request(other));
      ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
      if (!before) static_cast<void>(bench.controller->request(other));
      bench.tick();
      EXPECT_EQ(bench.mode(), Mode::kDamping) << static_cast<int>(other) << before;
    }
  }
}

TEST(Disarm, UntilItIsObeyedNothingSetsTheArmInMotion) {
  Bench bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->request(Command::kArm), 0);
  ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);  // takes the arm command back
  for (const Command command : {Command::kArm, Command::kHome})
    EXPECT_NE(bench.controller->request(command) & firmware::kWrongMode, 0) << static_cast<int>(command);
  bench.tick();
  EXPECT_EQ(bench.mode(), Mode::kReady);
  EXPECT_EQ(bench.controller->request(Command::kArm), 0);
  bench.tick();
  ASSERT_EQ(bench.mode(), Mode::kArmed);
  ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
  EXPECT_NE(bench.controller->request(Command::kArm) & firmware::kWrongMode, 0) << "armed, but not for long";
}

TEST(Disarm, NothingSetsTheArmInMotionAfterALoopThatStoodStill) {
  for (const Command command : {Command::kArm, Command::kHome}) {
    for (const std::uint64_t lost : {4U, 5U, 100'000U}) {
      Bench bench;
      bench.load();
      bench.home();
      ASSERT_EQ(bench.controller->request(command), 0);
      bench.inputs.tick += lost;
      bench.tick();
      EXPECT_EQ(bench.mode() != Mode::kReady, lost <= 4) << static_cast<int>(command) << " " << lost;
      bench.ticks(2);
      EXPECT_EQ(bench.mode() == Mode::kArmed, command == Command::kArm && lost <= 4);
    }
  }
}

// A host that clears a fault does not know of a stop that has come since it asked.
TEST(Stop, GoesBeforeAClearOfTheSameTick) {
  for (const bool before : {false, true}) {
    Bench bench;
    bench.load();
    bench.home();
    ASSERT_EQ(bench.controller->request(Command::kStop), 0);
    bench.tick();
    ASSERT_EQ(bench.mode(), Mode::kFaulted);
    if (before) static_cast<void>(bench.controller->request(Command::kStop));
    ASSERT_EQ(bench.controller->request(Command::kClear), 0);
    if (!before) static_cast<void>(bench.controller->request(Command::kStop));
    bench.tick();
    EXPECT_EQ(bench.mode(), Mode::kFaulted) << before;
    EXPECT_EQ(bench.controller->fault(), Fault::host_stop) << before;
    ASSERT_EQ(bench.controller->request(Command::kClear), 0);
    bench.tick();
    EXPECT_EQ(bench.mode(), Mode::kReady) << "a clear that comes after it is obeyed";
  }
}

// The host whose clear was not carried out is told so.
TEST(Stop, RefusesAClearOfTheSameTick) {
  Bench bench;
  bench.load();
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  static_cast<void>(bench.controller->request(Command::kStop));
  tester.run(1);
  bench.halted = true;
  tester.post({0x14, 0xFF, 0xFF, 0xFF});
  tester.run(5);
  bench.controller->on_frame(link::to_frame(link::EmergencyStop{}, 0), bench.inputs.time_us);
  bench.halted = false;
  EXPECT_EQ(tester.posted_answer(),
            (Bytes{link::kNegative, 0x14, static_cast<std::uint8_t>(link::Nrc::kConditionsNotCorrect)}));
  EXPECT_EQ(tester.text(link::kDidRefusal), "fault_latched");
  EXPECT_TRUE(tester.ok({0x14, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(bench.mode(), Mode::kReady);
}

// What waits for another host's job has been asked for before the stop.
TEST(Stop, GoesBeforeAClearThatWaitsForAnotherHost) {
  Bench bench;
  bench.load();
  bench.home();
  Tester first(bench, false, 1), waiting(bench, false, 2);
  ASSERT_TRUE(first.ok({0x10, 0x03}));
  ASSERT_TRUE(waiting.ok({0x10, 0x03}));
  static_cast<void>(bench.controller->request(Command::kStop));
  first.run(1);
  bench.halted = true;
  first.post({0x31, 0x02, 0x02, 0x06});  // the end of a move needs no lease
  first.run(5);
  waiting.post({0x14, 0xFF, 0xFF, 0xFF});
  waiting.run(5);
  bench.controller->on_frame(link::to_frame(link::EmergencyStop{}, 0), bench.inputs.time_us);
  bench.halted = false;
  EXPECT_EQ(waiting.posted_answer(),
            (Bytes{link::kNegative, 0x14, static_cast<std::uint8_t>(link::Nrc::kConditionsNotCorrect)}));
  EXPECT_EQ(bench.mode(), Mode::kFaulted);
  EXPECT_TRUE(waiting.ok({0x14, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(bench.mode(), Mode::kReady);
}

// The judge keeps the order of what was asked for: after a tick that follows a disarm, the arm is neither armed nor homing unless that
// was asked for, and accepted, after the disarm was obeyed. After a tick that follows a stop a fault is latched.
TEST(Disarm, RandomOrdersWithoutAPause) {
  constexpr int kRounds = 200'000;
  Random random(3);
  Bench bench;
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("stop_time")->id, 0),
            firmware::ParamStatus::kOk);
  bench.load();
  bench.home();
  int disarms = 0;
  int stops = 0;
  int disobeyed = 0;
  int armed = 0;
  bool stop = false;
  for (int round = 0; round < kRounds; ++round) {
    bool disarm = false;
    for (std::uint64_t n = random.below(4); n > 0; --n) {
      constexpr std::array kCommands = {Command::kHome,    Command::kArm,   Command::kArm,
                                        Command::kClear,   Command::kStop,  Command::kRecord,
                                        Command::kEndMove, Command::kDisarm};
      Command command = kCommands[random.below(kCommands.size())];
      if (command == Command::kStop && random.below(50) != 0) command = Command::kArm;
      static_cast<void>(bench.controller->request(command));
      disarm = disarm || command == Command::kDisarm;
      stop = stop || command == Command::kStop;
    }
    if (random.below(3) == 0) continue;  // the background is faster than the tick
    bench.tick();
    if (bench.mode() == Mode::kArmed) ++armed;
    if (stop) ++stops;
    if (stop && bench.controller->fault() == Fault::kNone) ++disobeyed;
    stop = false;
    if (!disarm) continue;
    ++disarms;
    if (moves(bench.mode())) ++disobeyed;
  }
  figure("disarms among random commands", disarms, "> 10000");
  figure("stops among them", stops, "> 500");
  figure("armed in so many ticks", armed, "> 1000");
  figure("of the disarms and stops, disobeyed", disobeyed, "0");
  EXPECT_GT(disarms, 10'000);
  EXPECT_GT(stops, 500);
  EXPECT_GT(armed, 1000);
  EXPECT_EQ(disobeyed, 0);
}

TEST(Disarm, IsAnsweredAfterTheTickThatObeyed) {
  Bench bench;
  bench.start();
  Tester tester(bench);
  bench.halted = true;
  tester.post({0x31, 0x01, 0x02, 0x02});
  tester.run(100);
  EXPECT_TRUE(std::none_of(
      bench.for_testers.begin(), bench.for_testers.end(),
      [](const link::CanFrame& frame) { return frame.size > 1 && frame.data[1] == 0x31 + link::kPositive; }));
  bench.halted = false;
  const Bytes answer = tester.posted_answer();
  ASSERT_FALSE(answer.empty());
  EXPECT_EQ(answer[0], 0x31 + link::kPositive);
  EXPECT_EQ(bench.mode(), Mode::kDamping);
}

// Of two programs with the tester's address: the arming of one waits for its tick, and the other one disarms.
TEST(Disarm, IsHeardWhileAnotherRequestFromTheAddressIsPending) {
  Bench bench;
  bench.load();
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  bench.halted = true;
  tester.post({0x31, 0x01, 0x02, 0x01});
  tester.run(5);
  link::CanFrame frame;
  frame.id = link::request_id(1);
  frame.extended = true;
  frame.size = 8;
  frame.data = {4, 0x31, 0x01, 0x02, 0x02};
  bench.controller->on_frame(frame, bench.inputs.time_us);
  bench.halted = false;
  EXPECT_EQ(tester.posted_answer(), (Bytes{0x31 + link::kPositive, 0x01, 0x02, 0x02}))
      << "not busy, and not of the arming";
  for (int tick = 0; tick < 50; ++tick) {
    tester.run(1);
    ASSERT_NE(bench.mode(), Mode::kArmed);
  }
}

// What waits for another host's job has been asked for before the disarm.
TEST(Disarm, GoesBeforeWhatWaitsForAnotherHost) {
  for (const std::uint8_t routine : {std::uint8_t{0x01}, std::uint8_t{0x03}}) {  // arming, homing
    Bench bench;
    bench.load();
    bench.home();
    Tester first(bench, false, 1), waiting(bench, false, 2), last(bench, false, 3);
    ASSERT_TRUE(first.ok({0x10, 0x03}));
    ASSERT_TRUE(waiting.ok({0x10, 0x03}));
    bench.halted = true;
    first.post({0x31, 0x01, 0x02, 0x01});
    first.run(5);
    waiting.post({0x31, 0x01, 0x02, routine});
    waiting.run(5);
    last.post({0x31, 0x01, 0x02, 0x02});
    last.run(5);
    bench.halted = false;
    for (int tick = 0; tick < 50; ++tick) {
      waiting.run(1);
      ASSERT_FALSE(moves(bench.mode())) << static_cast<int>(routine);
    }
    EXPECT_EQ(waiting.posted_answer()[0], link::kNegative);
  }
}

TEST(Disarm, OfARestartIsNotLostEither) {
  Bench bench;
  bench.start();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  ASSERT_TRUE(tester.ok({0x11, 0x01}));
  tester.run(1);
  EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x01}), firmware::link::Nrc::kBusyRepeatRequest);
  EXPECT_EQ(tester.text(firmware::link::kDidRefusal), "restarting");
  bool restarts = false;
  for (int n = 0; n < 4000 && !restarts; ++n) {
    tester.run(1);
    restarts = bench.controller->take_reset().has_value();
  }
  EXPECT_TRUE(restarts);
}

}  // namespace
}  // namespace thimble::test
