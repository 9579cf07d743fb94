// Recordings: fed to a fresh controller they give the same forces again, to the bit; they end where they would not; entries that are
// dropped are counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "firmware/store/slot_header.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using firmware::Recorder;
using link::RecordingEnd;
using link::RecordingPhase;

constexpr unsigned kTickMask = (1U << link::kRecordedTickBits) - 1;

struct RecordedFrames {
  std::vector<link::RecordingCounts> counts;
  std::vector<link::RecordingCheck> checks;
};

// What the link brings until nothing is left.
void receive(Bench& bench, RecordedFrames& heard) {
  link::CanFrame frame;
  while (bench.controller->next_frame(frame, bench.inputs.time_us)) {
    link::RecordingCounts counts;
    link::RecordingCheck check;
    if (link::from_frame(frame, 1, counts)) heard.counts.push_back(counts);
    if (link::from_frame(frame, 1, check)) {
      heard.checks.push_back(check);
    }
  }
}

// A session with the services, for what only they have.
class RecordingTester {
 public:
  explicit RecordingTester(Bench& bench) : bench_(bench) {}
  std::vector<std::uint8_t> ask(const std::vector<std::uint8_t>& request) {
    link::IsoTpChannel channel(link::request_id(1), link::response_id(1), link::IsoTpConfig{});
    EXPECT_TRUE(channel.send(request, bench_.inputs.time_us));
    for (int i = 0; i < 2000; ++i) {
      const link::Micros now = bench_.inputs.time_us;
      link::CanFrame frame;
      while (channel.next_frame(frame, now)) bench_.controller->on_frame(frame, now);
      bench_.controller->poll(now);
      while (bench_.controller->next_frame(frame, now)) {
        if (frame.extended) {
          static_cast<void>(channel.on_frame(frame, now));
        }
      }
      if (!channel.received().empty()) {
        std::vector<std::uint8_t> answer(channel.received().begin(), channel.received().end());
        channel.release();
        if (answer.size() == 3 && answer[0] == 0x7F && answer[2] == 0x78) continue;
        return answer;
      }
      bench_.tick();
    }
    ADD_FAILURE() << "no answer";
    return {0};
  }

 private:
  Bench& bench_;
};

firmware::RecordingStart started_with(Bench& bench) {
  RecordingTester asker(bench);
  EXPECT_EQ(asker.ask({0x10, 0x03})[0], 0x50);
  const std::vector<std::uint8_t> answer = asker.ask({0x31, 0x03, 0x02, 0x08});
  firmware::RecordingStart recording;
  auto& [start, arms] = recording;
  std::span<const std::uint8_t> rest = std::span(answer).subspan(4);
  EXPECT_TRUE(link::decode(rest, start));
  rest = rest.subspan(link::wire_size<link::RecordingStart>());
  for (std::size_t i = 0; i < start.arms; ++i) {
    EXPECT_TRUE(link::decode(rest, arms[i]));
    rest = rest.subspan(link::wire_size<link::RecordingArm>());
  }
  EXPECT_TRUE(rest.empty());
  return recording;
}

TEST(Recording, AFreshControllerGivesTheSameForces) {
  for (const std::uint8_t arms : {std::uint8_t{1}, std::uint8_t{2}}) {
    firmware::Config config;
    config.arm_count = arms;
    config.arm[1].base.home_m = {0.1F, 0, 0};
    Bench bench(config);
    bench.load(1000.0F, 0.0F, 2.0F);
    bench.home();
    bench.arm();
    bench.move({0.01, 0.02, -0.004}, 3000);  // heat, contact, a history
    ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
    bench.ticks(1500);
    ASSERT_EQ(bench.mode(), Mode::kReady);

    bench.move({0.01, 0.02, 0.003}, 1000);
    ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
    bench.tick();
    ASSERT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning);
    RecordedFrames heard;
    std::vector<std::array<float, 6>> forces;
    std::vector<Inputs> inputs;
    std::vector<Command> commands;
    const auto tick = [&](Command command = Command::kNone) {
      if (command != Command::kNone) {
        EXPECT_EQ(bench.controller->request(command), 0);
      }
      bench.tick();
      std::array<float, 6> force{};
      for (std::size_t i = 0; i < arms; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          force[3 * i + k] = bench.shown().arm[i].force_N[static_cast<Eigen::Index>(k)];
      forces.push_back(force);
      inputs.push_back(bench.inputs);
      commands.push_back(command);
      receive(bench, heard);
    };
    for (int i = 0; i < 37; ++i) tick();
    tick(Command::kArm);
    for (int i = 0; i < 2000; ++i) {
      bench.place({0.01 - 5e-6 * i, 0.02, 0.003 - 4e-6 * i});
      tick();
    }
    bench.inputs.dead_man = false;
    for (int i = 0; i < 40; ++i) tick();
    bench.inputs.dead_man = true;
    for (int i = 0; i < 1500; ++i) tick();
    tick(Command::kArm);
    for (int i = 0; i < 300; ++i) tick();
    EXPECT_EQ(bench.controller->recording_state().dropped, 0U);
    const firmware::RecordingStart recording = started_with(bench);
    Bench fresh(config);
    fresh.load(1000.0F, 0.0F, 2.0F);
    fresh.controller->resume(recording);
    std::size_t different = 0;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      fresh.controller->keep_alive();
      if (commands[i] != Command::kNone) fresh.controller->replay(commands[i]);
      static_cast<void>(fresh.controller->tick(inputs[i]));
      for (std::size_t k = 0; k < std::size_t{3} * arms; ++k) {
        const float force = fresh.shown().arm[k / 3].force_N[static_cast<Eigen::Index>(k % 3)];
        if (std::bit_cast<std::uint32_t>(force) != std::bit_cast<std::uint32_t>(forces[i][k])) ++different;
      }
    }
    EXPECT_EQ(different, 0U) << "of " << inputs.size() << " ticks";
    float most_N = 0;
    for (const auto& force : forces)
      for (const float part : force) most_N = std::max(most_N, std::abs(part));
    EXPECT_GT(most_N, 2.0F) << "nothing was felt";
  }
}

// Homing at an index, in the recording: levels and commands are fed as the checks tell them.
TEST(Recording, HomingComesOutAgain) {
  firmware::Config config;
  config.arm[0].has_index = true;
  Bench bench(config);
  bench.load();
  bench.ticks(10);
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.tick();
  RecordedFrames heard;
  const std::uint64_t first = bench.inputs.tick + 1;
  std::vector<Inputs> inputs;
  const auto ticks = [&](int count) {
    for (int i = 0; i < count; ++i) {
      bench.tick();
      inputs.push_back(bench.inputs);
      receive(bench, heard);
    }
  };
  ticks(20);
  ASSERT_EQ(bench.controller->request(Command::kHome), 0);
  ticks(100);
  EXPECT_EQ(bench.mode(), Mode::kHoming);
  bench.inputs.arm[0].index = true;
  ticks(1);
  bench.inputs.arm[0].index = false;
  ticks(20);
  ASSERT_EQ(bench.controller->request(Command::kArm), 0);
  for (int i = 0; i < 2000; ++i) {
    bench.place({0, 0, 0.002 - 3e-6 * i});
    ticks(1);
  }
  bench.inputs.arm[0].drive_fault = true;
  ticks(1);
  EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kFault);
  const firmware::RecordingStart recording = started_with(bench);

  Bench fresh(config);
  fresh.load();
  fresh.controller->resume(recording);
  std::uint32_t crc = 0;
  link::Levels levels = recording.start.levels;
  std::size_t agreed = 0;
  auto check = heard.checks.begin();
  for (const Inputs& from : inputs) {
    const auto now = static_cast<std::uint16_t>(from.tick);
    Inputs fed;  // of the counts only what travels
    fed.tick = from.tick;
    fed.arm[0].sample_tick = from.tick;
    fed.arm[0].counts = from.arm[0].counts;
    if (check->tick == (now & kTickMask)) {
      levels = check->levels;
      const auto command = static_cast<Command>(check->command);
      if (command != Command::kNone) fresh.controller->replay(command);
    }
    fed.dead_man = levels.dead_man;
    fed.arm[0].index = levels.index[0];
    fed.arm[0].drive_fault = levels.drive_fault[0];
    fresh.controller->keep_alive();
    static_cast<void>(fresh.controller->tick(fed));
    crc = firmware::crc32(std::as_bytes(std::span(fresh.shown().arm[0].force_N.data(), 3)), crc);
    for (; check != heard.checks.end() && check->tick == (now & kTickMask); ++check) {
      EXPECT_EQ(check->crc, crc) << from.tick - first;
      EXPECT_EQ(check->mode, fresh.mode()) << from.tick - first;
      ++agreed;
    }
    if (check == heard.checks.end()) break;
  }
  EXPECT_EQ(check, heard.checks.end());
  EXPECT_EQ(agreed, heard.checks.size());
  EXPECT_EQ(fresh.controller->fault(), Fault::drive_fault);
}

TEST(Recording, TheLinkHasEveryTickAndChecksWhereSomethingHappened) {
  Bench bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.tick();
  RecordedFrames heard;
  const std::uint64_t first = bench.inputs.tick + 1;
  std::uint64_t armed_at = 0;
  for (int i = 0; i < 100; ++i) {
    if (i == 50) {
      EXPECT_EQ(bench.controller->request(Command::kArm), 0);
      armed_at = bench.inputs.tick + 1;
    }
    bench.tick();
    receive(bench, heard);
  }
  ASSERT_EQ(heard.counts.size(), 100U);
  for (std::size_t i = 0; i < heard.counts.size(); ++i)
    EXPECT_EQ(heard.counts[i].tick, (first + i) & kTickMask);
  EXPECT_EQ(heard.counts.back().counts[1], static_cast<std::uint16_t>(bench.inputs.arm[0].counts[1]));
  std::size_t commands = 0;
  for (const link::RecordingCheck& check : heard.checks) {
    if (check.command == link::RecordedCommand::kNone) continue;
    ++commands;
    EXPECT_EQ(check.tick, armed_at & kTickMask);
    EXPECT_EQ(check.mode, Mode::kArmed);
    EXPECT_EQ(check.command, link::RecordedCommand::kArm);
    link::Levels held;
    held.dead_man = true;
    EXPECT_EQ(check.levels, held);
  }
  EXPECT_EQ(commands, 1U);
  EXPECT_EQ(heard.checks.size(), 7U);  // every 16 ticks, counted anew after the command's

  // The end says so, with the last tick's check.
  RecordingTester asker(bench);
  EXPECT_EQ(asker.ask({0x10, 0x03})[0], 0x50);
  EXPECT_EQ(asker.ask({0x31, 0x02, 0x02, 0x08})[0], 0x71);
  EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kStopped);
}

TEST(Recording, AFullRingIsCounted) {
  Bench bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.tick();
  bench.ticks(static_cast<int>(Recorder::kEntries) + 100);
  EXPECT_EQ(bench.controller->recording_state().dropped, 100U);
  EXPECT_EQ(bench.controller->recording_state().ticks, Recorder::kEntries + 100U);
  RecordedFrames heard;
  receive(bench, heard);
  EXPECT_EQ(heard.counts.size(), Recorder::kEntries);
  bench.tick();
  receive(bench, heard);
  EXPECT_EQ(heard.counts.back().tick, bench.inputs.tick & kTickMask) << "a gap, and then the next tick";
}

TEST(Recording, EndsWhereAHostGivesTheForces) {
  Bench bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->write_param(0x0123, 1), firmware::ParamStatus::kOk);
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.ticks(3);
  ASSERT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning);
  ASSERT_EQ(bench.controller->request(Command::kArm), 0);
  bench.tick();
  EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kEnded);
  EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kHostForces);
  EXPECT_EQ(bench.controller->recording_state().ticks, 2U);
}

TEST(Recorder, ABusThatIsTooSlowIsRefused) {
  firmware::Config config;
  config.arm_count = 2;
  config.arm[1].base.home_m = {0.1F, 0, 0};
  config.bus_bits_per_s = 1'000'000;
  Bench bench(config);
  bench.load();
  bench.home();
  RecordingTester asker(bench);
  EXPECT_EQ(asker.ask({0x10, 0x03})[0], 0x50);
  EXPECT_EQ(asker.ask({0x31, 0x01, 0x02, 0x08}), (std::vector<std::uint8_t>{0x7F, 0x31, 0x22}));
  const std::vector<std::uint8_t> why = asker.ask({0x22, 0xF1, 0xAA});
  EXPECT_EQ(std::string(why.begin() + 3, why.end()), "needs_can_fd_or_lower_rate");
}

struct EndCase {
  const char* what;
  RecordingEnd end;
  std::uint32_t ticks;  // of three that were good, and the event's
  std::function<void(Bench&)> event;
};

TEST(Recording, EndsWhereCountsDoNotDetermineTheForces) {
  const std::vector<EndCase> cases = {
      {"a parameter", RecordingEnd::kParameter, 4,
       [](Bench& b) {
         EXPECT_EQ(b.controller->write_param(0x0121, 1), firmware::ParamStatus::kNotWhileArmed)
             << "no end: refused";
         b.tick();
         EXPECT_EQ(b.controller->recording_state().phase, RecordingPhase::kRunning);
         EXPECT_EQ(b.controller->write_param(0x0101, std::bit_cast<std::uint32_t>(5000.0F)),
                   firmware::ParamStatus::kOk);
       }},
      {"a scene", RecordingEnd::kScene, 3, [](Bench& b) { b.load(500.0F); }},
      {"a lost tick", RecordingEnd::kTickLost, 3, [](Bench& b) { ++b.inputs.tick; }},
      {"a stale sample", RecordingEnd::kSampleStale, 3, [](Bench& b) { b.sampling = false; }},
      {"a fault", RecordingEnd::kFault, 4, [](Bench& b) { b.inputs.e_stop = true; }},
      {"a stop", RecordingEnd::kFault, 4,
       [](Bench& b) { EXPECT_EQ(b.controller->request(Command::kStop), 0); }},
      {"a silent host", RecordingEnd::kHostSilent, 3,
       [](Bench& b) {
         b.alive = false;
         b.controller->keep_alive();
       }},
  };
  for (const EndCase& c : cases) {
    Bench bench;
    bench.load();
    bench.home();
    bench.arm();
    ASSERT_NE(bench.controller->request(Command::kRecord), 0) << "with the motors on";
    ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
    bench.ticks(1200);
    ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
    bench.tick();
    RecordedFrames heard;
    ASSERT_EQ(bench.controller->request(Command::kArm), 0);
    bench.ticks(3);
    receive(bench, heard);
    c.event(bench);
    bench.tick();
    std::uint32_t more = 0;
    for (; bench.controller->recording_state().phase == RecordingPhase::kRunning && more < 5000; ++more) {
      bench.tick();
      receive(bench, heard);
    }
    receive(bench, heard);
    const link::RecordingState state = bench.controller->recording_state();
    EXPECT_EQ(state.end, c.end) << c.what;
    if (c.end != RecordingEnd::kHostSilent) {
      EXPECT_EQ(state.ticks, c.ticks) << c.what;
      EXPECT_EQ(more, 0U) << c.what;
    } else {
      EXPECT_NEAR(more, 4000, 5) << "link_timeout is 1 s";
    }
    EXPECT_EQ(heard.counts.size(), state.ticks) << c.what;
    ASSERT_FALSE(heard.checks.empty());
    EXPECT_TRUE(heard.checks.back().last) << c.what;
    EXPECT_EQ(heard.checks.back().tick, heard.counts.back().tick) << c.what;
  }
}

// A register of 16 bits goes over its edge all the time; one of 32 must not go farther than 16 tell.
TEST(Recording, WideCountersMayNotJump) {
  Bench narrow;
  narrow.count_at_home = 0xFFFF;
  narrow.counter_bits = 0xFFFF;
  narrow.load();
  narrow.home();
  ASSERT_EQ(narrow.controller->request(Command::kRecord), 0);
  narrow.tick();
  RecordedFrames heard;
  for (int i = 0; i < 400; ++i) {
    narrow.place({0.02 * std::sin(0.05 * i), 0, 0.01 * std::sin(0.07 * i)});
    narrow.tick();
    receive(narrow, heard);
  }
  EXPECT_EQ(narrow.controller->recording_state().phase, RecordingPhase::kRunning);
  EXPECT_EQ(heard.counts.size(), 400U);
  const auto high = [](const link::RecordingCounts& counts) { return counts.counts[0] > 0x8000; };
  EXPECT_TRUE(std::ranges::any_of(heard.counts, high));
  EXPECT_FALSE(std::ranges::all_of(heard.counts, high)) << "it never went over the edge";

  firmware::Config config;
  config.arm[0].model = "wooden";
  Bench wide(config);
  wide.load();
  wide.home();
  ASSERT_EQ(wide.controller->request(Command::kRecord), 0);
  wide.ticks(4);
  wide.count_at_home += 0x8000;
  wide.tick();
  EXPECT_EQ(wide.controller->recording_state().end, RecordingEnd::kCountsJumped);
  EXPECT_EQ(wide.controller->recording_state().ticks, 3U);
}

TEST(Recording, RefusedWhereItCannotBegin) {
  Bench bench;
  bench.tick();
  EXPECT_EQ(bench.controller->request(Command::kRecord), firmware::kNoScene);
  ASSERT_EQ(bench.controller->write_param(0x0123, 1), firmware::ParamStatus::kOk);
  bench.tick();
  EXPECT_EQ(bench.controller->unmet() & firmware::kNoScene, 0U) << "the host renders";
  bench.load();
  bench.tick();
  bench.inputs.e_stop = true;
  bench.tick();
  EXPECT_EQ(bench.controller->request(Command::kRecord) & firmware::kFaultLatched, firmware::kFaultLatched);
  bench.inputs.e_stop = false;
  bench.tick();
  EXPECT_EQ(bench.controller->request(Command::kClear), 0);
  bench.tick();
  EXPECT_EQ(bench.controller->request(Command::kRecord), 0) << "not homed: a recording may have that in it";
  bench.tick();
  RecordingTester asker(bench);
  EXPECT_EQ(asker.ask({0x10, 0x03})[0], 0x50);
  EXPECT_EQ(asker.ask({0x31, 0x01, 0x02, 0x08}), (std::vector<std::uint8_t>{0x7F, 0x31, 0x22})) << "it runs";
  EXPECT_EQ(asker.ask({0x2E, 0x01, 0x70, 0x10, 0, 0, 0})[0], 0x6E) << "telemetry_decimation is nothing to it";
  EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning);
  EXPECT_EQ(asker.ask({0x2E, 0x01, 0x01, 0, 0, 0, 0}), (std::vector<std::uint8_t>{0x7F, 0x2E, 0x31}));
  EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning)
      << "a value that is refused is nothing to it either";
  EXPECT_EQ(asker.ask({0x2E, 0x01, 0x01, 0, 0x40, 0x9C, 0x45})[0], 0x6E);
  EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kParameter);
  EXPECT_EQ(asker.ask({0x31, 0x01, 0x02, 0x08})[0], 0x71) << "the next one";
}

}  // namespace
}  // namespace thimble::test
