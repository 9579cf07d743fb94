// The two contexts at once: one thread ticks, the other arms, disarms, uploads scenes, trips, clears, writes
// parameters and reads records and freeze-frames, as the two contexts of a board do. What is read must be
// whole.
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cstdio>
#include <thread>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

// A record is whole when its parts belong to one tick: the bench writes the tick into the clock and the tick
// time.
bool whole(const Telemetry& t) { return t.time_us == 7 * t.tick; }
// And the counts, which change every eight ticks.
bool whole(const firmware::FrozenTick& t) {
  const auto& counts = t.arm[0].counts;
  const auto steps = static_cast<int>((t.tick - 1) / 8);
  return counts[0] == static_cast<std::uint32_t>(steps % 2) &&
         counts[1] == static_cast<std::uint32_t>(-(steps % 20));
}

TEST(Contexts, ServoAndBackgroundAtOnce) {
  constexpr int kTicks = 200000;
  firmware::Params params;
  firmware::Core core({}, params);
  const std::vector<std::byte> images[2] = {plane_image(500.0F, 0.0F), plane_image(900.0F, -0.001F)};
  control::SceneView scenes[2];
  for (int i = 0; i < 2; ++i)
    ASSERT_EQ(control::SceneView::check(images[i], scenes[i]), control::ImageStatus::kOk);
  std::atomic<bool> done{false};
  std::thread ticking([&] {
    Inputs inputs;
    inputs.dead_man = true;
    for (int i = 0; i < kTicks; ++i) {
      ++inputs.tick;
      inputs.time_us = 7 * inputs.tick;
      inputs.arm[0].sample_tick = inputs.tick;
      inputs.arm[0].counts = {static_cast<std::uint32_t>(i / 8 % 2),
                              static_cast<std::uint32_t>(-(i / 8 % 20)), 0};
      (void)core.tick(inputs);
      if (i % 64 == 0) std::this_thread::yield();  // on one core the background needs a turn
    }
    done = true;
  });
  int records = 0, frames = 0, armed = 0, torn = 0;
  std::uint32_t swaps = 0;
  std::uint64_t last_tick = 0;
  Telemetry t;
  const firmware::ParamRow& max_force = *firmware::find_param("max_force");
  const firmware::ParamRow& decimation = *firmware::find_param("telemetry_decimation");
  EXPECT_EQ(params.write(decimation.id, 3, true), firmware::ParamStatus::kOk);
  for (int i = 0; !done; ++i) {
    core.commands().keep_alive();
    if (i % 5 == 0 && core.sources().scene.post(scenes[swaps % 2], swaps + 1)) ++swaps;
    (void)core.commands().request(i % 50 == 49 ? Command::kStop : Command::kClear);
    (void)core.commands().request(Command::kHome);
    (void)core.commands().request(Command::kArm);
    (void)params.write(max_force.id, std::bit_cast<std::uint32_t>(1.0F + static_cast<float>(i % 8)), false);
    armed += core.status().mode() == Mode::kArmed ? 1 : 0;
    while (core.observers().records.next(t)) {
      torn += whole(t) && t.tick > last_tick ? 0 : 1;
      last_tick = t.tick;
      ++records;
    }
    firmware::FrozenTick frozen;
    for (std::size_t k = 0; core.observers().freeze.tick(k, frozen); ++k) {
      torn += whole(frozen) ? 0 : 1;
      ++frames;
    }
    std::this_thread::yield();
  }
  ticking.join();
  std::printf("%d ticks: %d records, %d freeze-frame ticks, %u scenes posted, armed %d times seen, %d torn\n",
              kTicks, records, frames, swaps, armed, torn);
  EXPECT_EQ(torn, 0);
  EXPECT_GT(records, 100);
  EXPECT_GT(frames, 64);
  EXPECT_GT(swaps, 2U);
  EXPECT_GT(armed, 2);
}

// Recordings begun, read and ended while the tick runs: each entry is whole, and ticks only go up.
TEST(Contexts, ARecordingIsReadWhileItGrows) {
  constexpr int kTicks = 200000;
  firmware::Params params;
  firmware::Core core({}, params);
  const std::vector<std::byte> image = plane_image(500.0F, 0.0F);
  control::SceneView scene;
  ASSERT_EQ(control::SceneView::check(image, scene), control::ImageStatus::kOk);
  ASSERT_TRUE(core.sources().scene.post(scene, 1));
  std::atomic<bool> done{false};
  std::atomic<int> reads{0};
  std::thread ticking([&] {
    Inputs inputs;
    inputs.dead_man = true;
    for (int i = 0; i < kTicks; ++i) {
      ++inputs.tick;
      inputs.arm[0].sample_tick = inputs.tick;
      const auto count = static_cast<std::uint32_t>(inputs.tick);  // a count a tick
      inputs.arm[0].counts = {count, count + 1, count + 2};
      (void)core.tick(inputs);
      if (i % 64 == 0) std::this_thread::yield();
      // The reader tells the order of ticks by 16 bits: on a loaded machine it must not fall behind by half of that.
      if (i % 0x4000 == 0) {
        for (const int before = reads; reads == before;) std::this_thread::yield();
      }
    }
    done = true;
  });
  int entries = 0, torn = 0, ends = 0;
  std::uint32_t dropped = 0;
  std::uint16_t last_tick = 0;
  firmware::RecordingEntry entry;
  while (!done) {
    core.commands().keep_alive();
    (void)core.commands().request(Command::kRecord);
    for (int i = 0; i < 200 && core.observers().recorder.next(entry); ++i) {
      const bool follows = static_cast<std::uint16_t>(entry.tick - last_tick) < 0x8000;
      const bool fits =
          !entry.counted() || (entry.counts[0][0] == entry.tick &&
                               entry.counts[0][2] == static_cast<std::uint16_t>(entry.tick + 2));
      if (!follows || !fits) ++torn;
      last_tick = entry.tick;
      ++entries;
      if (!entry.counted()) ++ends;
    }
    if (entries % 7 == 0) core.observers().recorder.request_end(firmware::RecordingEnd::kStopped);
    ++reads;
    dropped += core.observers().recorder.state().dropped != 0 ? 1U : 0U;
    std::this_thread::yield();
  }
  ticking.join();
  std::printf("%d ticks: %d entries, %d ends, full %u times seen, %d torn\n", kTicks, entries, ends, dropped,
              torn);
  EXPECT_EQ(torn, 0);
  EXPECT_GT(entries, 1000);
}

}  // namespace
}  // namespace thimble::test
