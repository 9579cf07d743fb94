// Recordings of which the counts alone are wanted (routine 0211): they go on where counts do not determine the forces, others do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/unit/firmware/axis_rig.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using link::RecordingEnd;
using link::RecordingPhase;

const Bytes kOpen = {0x10, 0x03}, kStart = {0x31, 0x01, 0x02, 0x08}, kStartCounts = {0x31, 0x01, 0x02, 0x11},
            kEnd = {0x31, 0x02, 0x02, 0x08}, kArm = {0x31, 0x01, 0x02, 0x01};

bool write_force_slew(Tester& tester) { return tester.ok({0x2E, 0x01, 0x01, 0, 0x40, 0x9C, 0x45}); }

std::size_t counts_of(const Tester& tester) {
  return static_cast<std::size_t>(std::ranges::count_if(tester.seen, [](const link::CanFrame& frame) {
    link::RecordingCounts counts;
    return link::from_frame(frame, 1, counts);
  }));
}

TEST(RecordingCounts, GoesOnWhereForcesAreNotDetermined) {
  Bench bench;
  write_param(bench, "allow_moves", 1U);
  bench.load(1000.0F, -0.01F);
  bench.home();
  Tester tester(bench, true);
  ASSERT_TRUE(tester.ok(kOpen));
  ASSERT_TRUE(tester.ok(kStartCounts));
  EXPECT_EQ(tester.ask({0x31, 0x03, 0x02, 0x08}).size(),
            4 + link::wire_size<link::RecordingStart>() + link::wire_size<link::RecordingArm>());
  const auto runs = [&](const char* after) {
    tester.run(5);
    EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning) << after;
  };
  ASSERT_TRUE(write_force_slew(tester));
  runs("a parameter");
  link::HomePlace place;
  std::copy_n(bench.inputs.arm[0].counts.begin(), 3, place.raw.begin());
  Bytes home = {0x31, 0x01, 0x02, 0x10};
  home.resize(4 + link::wire_size<link::HomePlace>());
  ASSERT_NE(link::encode(place, std::span(home).subspan(4)), 0U);
  ASSERT_TRUE(tester.ok(home));
  runs("a place");
  ASSERT_TRUE(tester.ok(kArm));
  tester.run(900);
  runs("arming");
  ASSERT_EQ(bench.controller->request_axes(axis_torque(1, 0.02F)), 0);
  runs("an order for the axes");
  tester.run(500);
  runs("an arm that is let go");
  tester.run(1100);
  bench.load(500.0F, -0.01F);
  runs("a scene");
  ASSERT_TRUE(tester.ok(kEnd));
  const link::RecordingState state = bench.controller->recording_state();
  EXPECT_EQ(state.end, RecordingEnd::kStopped);
  EXPECT_EQ(state.dropped, 0U);
  EXPECT_GT(state.ticks, 2500U);
  tester.run(2);
  EXPECT_EQ(counts_of(tester), state.ticks) << "every tick came";
}

struct EndCase {
  RecordingEnd end;
  void (*event)(Bench&);
};

// What leaves no whole row of counts ends it, and a fault, which ends what the host does.
TEST(RecordingCounts, EndsWhereCountsAreMissing) {
  const EndCase kCases[] = {
      {RecordingEnd::kTickLost, [](Bench& b) { ++b.inputs.tick; }},
      {RecordingEnd::kCountsJumped, [](Bench& b) { b.count_at_home += 0x8000; }},
      {RecordingEnd::kFault, [](Bench& b) { b.inputs.e_stop = true; }},
  };
  for (const EndCase& c : kCases) {
    firmware::Config config;
    config.arm[0].model = "wooden";  // its counters have 32 bits
    Bench bench(config);
    bench.load();
    bench.home();
    Tester tester(bench, true);
    ASSERT_TRUE(tester.ok(kOpen));
    ASSERT_TRUE(tester.ok(kStartCounts));
    tester.run(10);
    c.event(bench);
    tester.run(1);
    EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kEnded);
    EXPECT_EQ(bench.controller->recording_state().end, c.end);
  }
}

// The next recording is one of forces again: after one of counts, and after one of counts that was refused.
TEST(RecordingCounts, TheNextRecordingEndsAsBefore) {
  const auto recorded = [](Tester& tester) {
    ASSERT_TRUE(tester.ok(kStartCounts));
    tester.run(10);
    ASSERT_TRUE(tester.ok(kEnd));
  };
  const auto refused = [](Tester& tester) {
    ASSERT_TRUE(tester.ok(kArm));
    EXPECT_EQ(tester.refused(kStartCounts), link::Nrc::kConditionsNotCorrect);
    ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x02}));
    tester.run(1200);
  };
  const auto runs_already = [](Tester& tester) {
    ASSERT_TRUE(tester.ok(kStart));
    EXPECT_EQ(tester.refused(kStartCounts), link::Nrc::kConditionsNotCorrect);
    ASSERT_TRUE(tester.ok(kEnd));
  };
  for (void (*before)(Tester&) : {+recorded, +refused, +runs_already}) {
    Bench bench;
    bench.load();
    bench.home();
    Tester tester(bench, true);
    ASSERT_TRUE(tester.ok(kOpen));
    before(tester);
    ASSERT_TRUE(tester.ok(kStart));
    tester.run(10);
    EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kRunning);
    ASSERT_TRUE(write_force_slew(tester));
    EXPECT_EQ(bench.controller->recording_state().phase, RecordingPhase::kEnded);
    EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kParameter);
  }
}

// One that runs keeps what it is, whatever a host asks for meanwhile.
TEST(RecordingCounts, ARecordingThatRunsKeepsItsKind) {
  Bench bench;
  bench.load();
  bench.home();
  Tester tester(bench, true);
  ASSERT_TRUE(tester.ok(kOpen));
  ASSERT_TRUE(tester.ok(kStart));
  EXPECT_EQ(tester.refused(kStartCounts), link::Nrc::kConditionsNotCorrect);
  ASSERT_TRUE(write_force_slew(tester));
  EXPECT_EQ(bench.controller->recording_state().end, RecordingEnd::kParameter);
}

}  // namespace
}  // namespace thimble::test
