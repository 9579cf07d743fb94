// Marks: writes of `event` and `trial`. The event line rises in the tick that the host and a recording are told, whatever else happens;
// what stops the arm ends its pulse; a recording goes on, and comes out again with its trials.
#include "firmware/core/marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "firmware/store/slot_header.h"
#include "tests/support/random.h"
#include "tests/unit/firmware/tester.h"
#include "tests/unit/firmware/trials_scene.h"

namespace thimble::test {
namespace {

using firmware::ParamStatus;
using link::MarkKind;

constexpr std::uint16_t kEvent = 0x0191, kTrial = 0x0190;
constexpr std::uint32_t kMarkTickMask = (1U << link::kRecordedTickBits) - 1;

// A bench that keeps the level of the event line in every tick: a scope at the pin.
class Scope : public Bench {
 public:
  using Bench::Bench;
  const Outputs& tick() {
    const Outputs& out = Bench::tick();
    line.resize(static_cast<std::size_t>(inputs.tick) + 1);
    line[static_cast<std::size_t>(inputs.tick)] = out.event;
    return out;
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }
  [[nodiscard]] std::vector<std::uint64_t> edges() const {
    std::vector<std::uint64_t> rising;
    for (std::size_t i = 1; i < line.size(); ++i)
      if (line[i] && !line[i - 1]) rising.push_back(i);
    return rising;
  }
  [[nodiscard]] std::ptrdiff_t high() const { return std::count(line.begin(), line.end(), true); }

  std::vector<bool> line;
};

Bytes writes(std::uint16_t id, std::uint16_t value) {
  return {0x2E,
          static_cast<std::uint8_t>(id >> 8),
          static_cast<std::uint8_t>(id),
          static_cast<std::uint8_t>(value),
          static_cast<std::uint8_t>(value >> 8),
          0,
          0};
}

link::Marked marked_of(TesterOf<Scope>& host) {
  link::Marked marked;
  EXPECT_TRUE(link::decode(host.read(link::Marked::kId), marked));
  return marked;
}

bool mark(Scope& bench, std::uint16_t id, std::uint32_t value) {
  return bench.controller->write_param(id, value) == ParamStatus::kOk;
}

TEST(Marks, TheLineRisesInTheTickThatTheHostIsTold) {
  Scope bench;
  TesterOf<Scope> host(bench);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  EXPECT_EQ(marked_of(host).count, 0U);
  Random random(1);
  std::vector<std::uint64_t> told;
  for (std::uint16_t i = 0; i < 100; ++i) {
    host.run(static_cast<int>(40 + random.below(20)));
    const std::uint16_t id = i % 3 == 2 ? kTrial : kEvent;
    const auto value = static_cast<std::uint16_t>(id == kTrial ? i : 65535U - i);
    ASSERT_TRUE(host.ok(writes(id, value)));
    const link::Marked marked = marked_of(host);
    EXPECT_EQ(marked_of(host).count, marked.count)
        << "reading changes nothing: a lost answer is asked for again";
    EXPECT_EQ(marked.count, i + 1U);
    EXPECT_EQ(marked.what, id == kTrial ? MarkKind::kTrial : MarkKind::kEvent);
    EXPECT_EQ(marked.value, value);
    told.push_back(marked.tick);
    EXPECT_EQ(host.read(id),
              (Bytes{static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8), 0, 0}));
  }
  host.run(50);
  EXPECT_EQ(bench.edges(), told);
  EXPECT_EQ(bench.high(), 100 * 40) << "10 ms at 4 kHz";
  EXPECT_NE(host.refused(writes(kTrial, 256)), link::Nrc::kOk);
  EXPECT_EQ(marked_of(host).count, 100U);
}

TEST(Marks, APulseLastsTenMillisecondsOrATickMoreAtAnyRate) {
  for (const auto& [rate_Hz, ticks] : {std::pair(50.0F, 1),
                                       {100.0F, 1},
                                       {1000.0F, 10},
                                       {1140.0F, 12},
                                       {3000.0F, 30},
                                       {3333.0F, 34},
                                       {20000.0F, 200}}) {
    firmware::Config config;
    config.period_s = 1.0F / rate_Hz;
    Scope bench(config);
    bench.ticks(5);
    ASSERT_TRUE(mark(bench, kEvent, 1));
    bench.ticks(300);
    EXPECT_EQ(bench.edges(), std::vector<std::uint64_t>{6});
    EXPECT_EQ(bench.high(), ticks) << rate_Hz;
  }
}

// Each tick takes one mark. The line stays active until 10 ms after the last one.
TEST(Marks, MarksInTicksThatFollowEachOtherExtendThePulse) {
  Scope bench;
  bench.load();
  bench.home();
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.tick();
  std::vector<link::RecordingMark> heard;
  const auto listen = [&] {
    link::CanFrame frame;
    link::RecordingMark read;
    while (bench.controller->next_frame(frame, bench.inputs.time_us))
      if (link::from_frame(frame, 1, read)) heard.push_back(read);
  };
  const std::uint64_t first = bench.inputs.tick + 1;
  for (std::uint16_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(mark(bench, i % 2 == 0 ? kEvent : kTrial, i));
    EXPECT_EQ(bench.controller->write_param(kEvent, 999), ParamStatus::kBusy) << "one waits for its tick";
    bench.tick();
    listen();
  }
  bench.ticks(60);
  listen();
  EXPECT_EQ(bench.edges(), std::vector<std::uint64_t>{first});
  EXPECT_EQ(bench.high(), 99 + 40);
  ASSERT_EQ(heard.size(), 100U);
  for (std::uint16_t i = 0; i < 100; ++i) {
    EXPECT_EQ(heard[i].tick, (first + i) & kMarkTickMask);
    EXPECT_EQ(heard[i].value, i);
    EXPECT_EQ(heard[i].before, i < 2 ? 0 : i - 2);
    EXPECT_EQ(heard[i].number, i);
    EXPECT_EQ(heard[i].what, i % 2 == 0 ? MarkKind::kEvent : MarkKind::kTrial);
  }
  EXPECT_EQ(bench.controller->recording_state().phase, link::RecordingPhase::kRunning);
  EXPECT_EQ(bench.controller->recording_state().marks, 100U);
}

// Two hosts write at the same time: each reads its own mark, and no tick is told twice.
TEST(Marks, EachHostReadsItsOwn) {
  Scope bench;
  TesterOf<Scope> one(bench, true, 11), two(bench, true, 22);
  ASSERT_TRUE(one.ok({0x10, 0x03}));
  ASSERT_TRUE(two.ok({0x10, 0x03}));
  std::vector<std::uint32_t> ticks;
  for (std::uint16_t i = 0; i < 50; ++i) {
    one.post(writes(kEvent, i));
    two.post(writes(kEvent, static_cast<std::uint16_t>(1000 + i)));
    EXPECT_EQ(one.posted_answer().at(0), 0x6E);
    EXPECT_EQ(two.posted_answer().at(0), 0x6E);
    const link::Marked first = marked_of(one), second = marked_of(two);
    EXPECT_EQ(first.value, i);
    EXPECT_EQ(second.value, 1000 + i);
    EXPECT_EQ(first.count, i + 1U);
    EXPECT_EQ(second.count, i + 1U);
    EXPECT_TRUE(bench.line.at(first.tick) && bench.line.at(second.tick));
    ticks.push_back(first.tick);
    ticks.push_back(second.tick);
  }
  std::sort(ticks.begin(), ticks.end());
  EXPECT_EQ(std::adjacent_find(ticks.begin(), ticks.end()), ticks.end());
}

// Whatever stops the arm ends the pulse in the same tick, and it stays low. A mark of that very tick has its edge.
TEST(Marks, WhatStopsTheArmEndsThePulse) {
  using Stop = void (*)(Scope&);
  constexpr std::array<std::pair<const char*, Stop>, 5> kStops = {{
      {"disarm", [](Scope& bench) { ASSERT_EQ(bench.controller->request(Command::kDisarm), 0); }},
      {"stop",
       [](Scope& bench) {
         bench.controller->on_frame(link::to_frame(link::EmergencyStop{}, 0), bench.inputs.time_us);
       }},
      {"dead-man switch", [](Scope& bench) { bench.inputs.dead_man = false; }},
      {"e-stop", [](Scope& bench) { bench.inputs.e_stop = true; }},
      {"drive fault", [](Scope& bench) { bench.inputs.arm[0].drive_fault = true; }},
  }};
  for (const auto& [name, stop] : kStops) {
    for (const bool marks_that_tick : {false, true}) {
      Scope bench;
      bench.start();
      ASSERT_TRUE(mark(bench, kEvent, 1));
      bench.tick();
      bench.ticks(3);
      ASSERT_TRUE(bench.outputs.event) << name;
      stop(bench);
      if (marks_that_tick) {
        ASSERT_TRUE(mark(bench, kEvent, 2));
      }
      bench.tick();
      EXPECT_NE(bench.mode(), Mode::kArmed) << name;
      EXPECT_EQ(bench.outputs.event, marks_that_tick) << name;
      bench.ticks(2000);
      EXPECT_EQ(bench.high(), marks_that_tick ? 4 + 40 : 4) << name;
      // At rest and while faulted a mark is one as well.
      ASSERT_TRUE(mark(bench, kEvent, 3));
      bench.tick();
      EXPECT_TRUE(bench.outputs.event) << name;
      bench.ticks(100);
      EXPECT_FALSE(bench.outputs.event) << name;
    }
  }
}

TEST(Marks, ARestartBeginsWithTheLineLow) {
  Scope bench;
  bench.tick();
  ASSERT_TRUE(mark(bench, kEvent, 1));
  bench.tick();
  ASSERT_TRUE(bench.outputs.event);
  ASSERT_TRUE(mark(bench, kTrial, 5));  // no tick takes it
  bench.restart("host");
  bench.ticks(100);
  EXPECT_EQ(bench.high(), 1);
  std::uint32_t trial = 1;
  EXPECT_EQ(bench.controller->read_param(kTrial, trial), ParamStatus::kOk);
  EXPECT_EQ(trial, 0U);
}

// A recording with a switch every few ticks, fed to a fresh controller: the same forces to the bit. Without the switches, other ones.
TEST(Marks, ARecordingWithTrialsComesOutAgain) {
  Scope bench;
  ASSERT_EQ(bench.controller->load_scene(trials_image()), firmware::StoreStatus::kOk);
  bench.home();
  ASSERT_TRUE(mark(bench, kTrial, 2));
  bench.tick();
  ASSERT_EQ(bench.controller->request(Command::kRecord), 0);
  bench.tick();
  struct Row {
    Inputs inputs;
    bool arms;
    std::optional<std::uint32_t> trial;
    std::array<float, 3> force_N;
  };
  std::vector<Row> rows;
  Random random(3);
  const firmware::RecordingStart start = [&] {
    TesterOf<Scope> host(bench);
    EXPECT_TRUE(host.ok({0x10, 0x03}));
    const Bytes answer = host.ask({0x31, 0x03, 0x02, 0x08});
    firmware::RecordingStart read;
    EXPECT_TRUE(link::decode(std::span(answer).subspan(4), read.start));
    EXPECT_TRUE(
        link::decode(std::span(answer).subspan(4 + link::wire_size<link::RecordingStart>()), read.arms[0]));
    return read;
  }();
  bench.alive = true;
  // The ticks of that question are of the recording, too: the arm was at rest, and no tick of them had a force.
  for (int i = 0; i < 6000; ++i) {
    Row row{};
    row.arms = i == 20;
    if (row.arms) {
      ASSERT_EQ(bench.controller->request(Command::kArm), 0);
    }
    if (i > 100 && random.below(7) == 0) {
      row.trial = static_cast<std::uint32_t>(random.below(4));
      ASSERT_TRUE(mark(bench, kTrial, *row.trial));
    }
    bench.tick();
    row.inputs = bench.inputs;
    std::copy_n(bench.shown().arm[0].force_N.data(), 3, row.force_N.begin());
    rows.push_back(row);
  }
  EXPECT_EQ(bench.controller->recording_state().phase, link::RecordingPhase::kRunning);
  const auto different = [&](bool with_trials) {
    Bench fresh;
    EXPECT_EQ(fresh.controller->load_scene(trials_image()), firmware::StoreStatus::kOk);
    fresh.controller->resume(start, 2);
    Inputs before = rows.front().inputs;
    for (std::uint64_t tick = start.start.tick + 1; tick < rows.front().inputs.tick; ++tick) {
      before.tick = before.arm[0].sample_tick = tick;
      fresh.controller->keep_alive();
      static_cast<void>(fresh.controller->tick(before));
    }
    std::size_t count = 0;
    for (const Row& row : rows) {
      fresh.controller->keep_alive();
      if (row.arms) fresh.controller->replay(Command::kArm);
      if (row.trial && with_trials) {
        EXPECT_EQ(fresh.controller->write_param(kTrial, *row.trial), ParamStatus::kOk);
      }
      static_cast<void>(fresh.controller->tick(row.inputs));
      if (std::memcmp(fresh.shown().arm[0].force_N.data(), row.force_N.data(), sizeof(row.force_N)) != 0)
        ++count;
    }
    return count;
  };
  EXPECT_EQ(different(true), 0U);
  EXPECT_GT(different(false), 3000U);
  EXPECT_GT(std::abs(rows[1000].force_N[2]), 0.5F) << "nothing was felt";
}

}  // namespace
}  // namespace thimble::test
