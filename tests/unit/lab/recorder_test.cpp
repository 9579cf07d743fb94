// The recorder: frames to ticks, with every kind of loss, and the wrap of the transmitted numbers.
#include "host-tools/lab/recorder.h"

#include <gtest/gtest.h>

#include <sstream>

#include "firmware/link/services.h"
#include "host-tools/client/device.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;

constexpr std::uint8_t kNode = 3;

link::CanFrame counts_frame(std::uint64_t tick, std::size_t arm = 0) {
  link::RecordingCounts counts;
  counts.tick = static_cast<std::uint16_t>(tick);
  counts.arm = static_cast<std::uint8_t>(arm);
  counts.counts = {static_cast<std::uint16_t>(tick), counts.arm, 7};
  return link::to_frame(counts, kNode);
}

link::CanFrame check_frame(std::uint64_t tick, bool last = false) {
  link::RecordingCheck check;
  check.crc = static_cast<std::uint32_t>(tick);
  check.tick = static_cast<std::uint16_t>(tick);
  check.mode = link::Mode::kReady;
  check.levels.dead_man = true;
  check.last = last;
  return link::to_frame(check, kNode);
}

link::CanFrame mark_frame(std::uint64_t tick, std::uint16_t value, std::uint16_t number = 0) {
  link::RecordingMark mark;
  mark.tick = static_cast<std::uint16_t>(tick);
  mark.what = link::MarkKind::kTrial;
  mark.value = value;
  mark.before = static_cast<std::uint16_t>(value + 1);
  mark.number = number;
  return link::to_frame(mark, kNode);
}

struct Written {
  std::vector<host::RecordedTicks> ticks;
  std::vector<host::RecordedCheck> checks;
  std::vector<host::RecordedMark> marks;
  std::size_t frames = 0;
};

Written written(host::Recorder& recorder, std::uint32_t start_tick, std::uint8_t arms) {
  host::RecordingHeader header;
  SceneBuilder builder;
  builder.plane({0, 0, 1}, 0.0, {});
  header.scene = builder.bytes();
  header.scene_crc = host::crc32(header.scene);
  header.start.tick = start_tick;
  header.start.arms = arms;
  header.models.assign(arms, "premium-1.5");
  header.arms.resize(arms);
  std::ostringstream out;
  host::write_header(out, header);
  recorder.write(out);
  const std::string bytes = out.str();
  const host::Recording recording = host::parse_recording(std::as_bytes(std::span(bytes)), "file");
  return {recording.ticks, recording.checks, recording.marks, recording.frames.size()};
}

link::RecordingStart start_at(std::uint32_t tick) {
  link::RecordingStart start;
  start.tick = tick;
  return start;
}

TEST(Recorder, EveryTickOverTheWrapOfItsNumber) {
  constexpr std::uint64_t kStart = 0x1FFF0;
  host::Recorder recorder(kNode, 1);
  for (std::uint64_t tick = kStart - 50; tick < kStart + 10; ++tick)
    recorder.take(counts_frame(tick), 0);  // of the recording before, and early ones of this
  recorder.begin(start_at(kStart));
  for (std::uint64_t tick = kStart + 10; tick <= kStart + 70'000; ++tick) {
    recorder.take(counts_frame(tick), 0);
    if (tick % 16 == 0) recorder.take(check_frame(tick), 0);
  }
  link::CanFrame pose = link::to_frame(link::Pose{}, kNode);
  recorder.take(pose, 5);
  recorder.take(link::to_frame(link::RecordingCounts{}, kNode + 1),
                5);  // another node's is a frame like any other
  EXPECT_FALSE(recorder.ended());
  recorder.take(check_frame(kStart + 70'000, true), 0);
  EXPECT_TRUE(recorder.ended());
  recorder.take(counts_frame(kStart + 70'001), 0);  // of another recording
  EXPECT_EQ(recorder.ticks(), 70'000U);
  EXPECT_EQ(recorder.missing(), 0U);
  const Written result = written(recorder, kStart, 1);
  ASSERT_EQ(result.ticks.size(), 1U);
  EXPECT_EQ(result.ticks[0].first, kStart + 1);
  ASSERT_EQ(result.ticks[0].counts.size(), 3U * 70'000U);
  for (std::size_t i = 0; i < 70'000; ++i)
    ASSERT_EQ(result.ticks[0].counts[3 * i], static_cast<std::uint16_t>(kStart + 1 + i));
  EXPECT_EQ(result.checks.back().tick, kStart + 70'000);
  EXPECT_EQ(result.frames, 2U);
}

// A mark comes before the counts of its tick; marks are farther from each other than their bits of a tick tell, and frames may be missing or come
// twice.
TEST(Recorder, EachMarkHasItsTick) {
  constexpr std::uint64_t kStart = 0xFFFFFF00;  // its 32 bits wrap
  host::Recorder recorder(kNode, 1);
  recorder.take(mark_frame(kStart - 3, 99, 41), 0);  // of the recording before
  recorder.take(mark_frame(kStart + 1, 7), 0);
  recorder.begin(start_at(static_cast<std::uint32_t>(kStart)));
  std::vector<std::uint64_t> expected = {kStart + 1};
  std::uint16_t number = 0;
  for (std::uint64_t tick = kStart + 1; tick <= kStart + 70'000; ++tick) {
    if (tick % 9'973 == 0 || tick % 9'973 == 1) {
      number = static_cast<std::uint16_t>(number + (tick % 3 == 0 ? 2 : 1));  // some are lost
      for (int times = 0; times < 2; ++times)
        recorder.take(mark_frame(tick, static_cast<std::uint16_t>(tick), number), 0);
      expected.push_back(tick);
    }
    const bool lost = tick % 9'973 < 300 && tick % 2 == 0;
    if (!lost) recorder.take(counts_frame(tick), 0);
  }
  recorder.take(check_frame(kStart + 70'000, true), 0);
  recorder.take(mark_frame(kStart + 70'001, 1, 100), 0);  // behind the end
  EXPECT_EQ(recorder.marks(), expected.size());
  const Written result = written(recorder, static_cast<std::uint32_t>(kStart), 1);
  ASSERT_EQ(result.marks.size(), expected.size());
  EXPECT_GE(expected.size(), 15U);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(result.marks[i].tick, expected[i]);
    EXPECT_EQ(result.marks[i].value, static_cast<std::uint16_t>(i == 0 ? 7 : expected[i]));
    EXPECT_EQ(result.marks[i].before, static_cast<std::uint16_t>(result.marks[i].value + 1));
    EXPECT_EQ(result.marks[i].what, link::MarkKind::kTrial);
  }
}

TEST(Recorder, AMissingFrameIsAGapOfItsTick) {
  host::Recorder recorder(kNode, 2);
  recorder.begin(start_at(100));
  for (std::uint64_t tick = 101; tick <= 200; ++tick) {
    if (tick != 150) recorder.take(counts_frame(tick, 0), 0);
    if (tick != 160) recorder.take(counts_frame(tick, 1), 0);
    if (tick == 170) recorder.take(counts_frame(tick, 1), 0);  // twice
  }
  const Written result = written(recorder, 100, 2);
  ASSERT_EQ(result.ticks.size(), 3U);
  EXPECT_EQ(result.ticks[0].counts.size(), 49U * 6U);
  EXPECT_EQ(result.ticks[1].first, 151U);
  EXPECT_EQ(result.ticks[1].counts.size(), 9U * 6U);
  EXPECT_EQ(result.ticks[2].first, 161U);
  EXPECT_EQ(result.ticks[2].counts.size(), 40U * 6U);
  EXPECT_EQ(recorder.missing(), 2U);
  EXPECT_EQ(result.ticks[2].counts[4], 1U) << "the second arm's are the second three";
}

}  // namespace
}  // namespace thimble::test
