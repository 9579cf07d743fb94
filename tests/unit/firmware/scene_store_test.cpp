// The scene store: power lost at every byte of an upload, images that are not sound, resumed downloads, and
// what of all this the running scene notices (nothing).
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using firmware::crc32;
using firmware::SceneStore;
using firmware::StoreStatus;

StoreStatus upload(SceneStore& store, const std::vector<std::byte>& image, control::SceneView& view) {
  StoreStatus status = store.begin(image.size(), crc32(image));
  for (std::size_t at = 0; status == StoreStatus::kOk && at < image.size(); at += 64)
    status = store.write(at, std::span(image).subspan(at, std::min<std::size_t>(64, image.size() - at)));
  if (status == StoreStatus::kOk) status = store.verify();
  if (status == StoreStatus::kOk) status = store.commit(view);
  return status;
}

TEST(Crc32, IsTheCommonOne) {
  const char text[] = "123456789";
  EXPECT_EQ(crc32(std::as_bytes(std::span(text, 9))), 0xCBF43926U);  // the check value of every CRC catalogue
  EXPECT_EQ(crc32(std::as_bytes(std::span(text + 4, 5)), crc32(std::as_bytes(std::span(text, 4)))),
            0xCBF43926U);
}

TEST(SceneStore, KeepsTheNewestOverARestart) {
  TestStorage storage;
  control::SceneView view;
  {
    SceneStore store(storage);
    EXPECT_EQ(store.open(view), StoreStatus::kRefused);
    EXPECT_EQ(view.scene(), nullptr);
    for (const float stiffness : {100.0F, 200.0F, 300.0F})
      EXPECT_EQ(upload(store, plane_image(stiffness), view), StoreStatus::kOk);
  }
  SceneStore store(storage);
  ASSERT_EQ(store.open(view), StoreStatus::kOk);
  EXPECT_EQ(store.sequence(), 3U);
  EXPECT_EQ(store.image_crc(), crc32(plane_image(300.0F)));
  EXPECT_EQ(store.image_bytes(), plane_image(300.0F).size());
  EXPECT_FALSE(storage.overwritten);
}

// Cuts the power after every single byte that the storage erases or writes, in both erase orders, and starts
// again.
TEST(SceneStore, SurvivesPowerLossAtEveryByte) {
  const std::vector<std::byte> first = plane_image(100.0F), second = plane_image(200.0F),
                               third = plane_image(300.0F);
  int cuts = 0, old_scene = 0, new_scene = 0;
  for (const bool downwards : {false, true}) {
    for (const bool both_slots_full : {false, true}) {
      for (std::size_t budget = 0;; ++budget) {
        TestStorage storage;
        storage.erase_downwards = downwards;
        control::SceneView view;
        SceneStore before(storage);
        ASSERT_EQ(upload(before, first, view), StoreStatus::kOk);
        if (both_slots_full) {
          ASSERT_EQ(upload(before, second, view), StoreStatus::kOk);
        }
        const std::uint32_t old_crc = before.image_crc();
        storage.power_left = budget;
        const StoreStatus status = upload(before, third, view);
        storage.power_left = std::numeric_limits<std::size_t>::max();

        SceneStore after(storage);
        control::SceneView found;
        ASSERT_EQ(after.open(found), StoreStatus::kOk) << "power lost after byte " << budget;
        ASSERT_NE(found.scene(), nullptr);
        EXPECT_TRUE(after.image_crc() == old_crc || after.image_crc() == crc32(third)) << budget;
        if (status == StoreStatus::kOk) {
          EXPECT_EQ(after.image_crc(), crc32(third));
        }
        (after.image_crc() == old_crc ? old_scene : new_scene)++;
        ++cuts;
        // And the store goes on working.
        ASSERT_EQ(upload(after, second, found), StoreStatus::kOk) << budget;
        EXPECT_FALSE(storage.overwritten);
        if (status == StoreStatus::kOk) break;
      }
    }
  }
  std::printf("%d cuts: %d times the old scene, %d times the new one\n", cuts, old_scene, new_scene);
  EXPECT_EQ(cuts, 4 * (static_cast<int>(SceneStore::kHeaderBytes + 2 * third.size()) + 24 +
                       1));  // erase, image, header
  EXPECT_EQ(new_scene, 4);   // only the complete uploads
}

TEST(SceneStore, FallsBackToTheOlderSlotWhenTheNewerRots) {
  const std::vector<std::byte> first = plane_image(100.0F), second = plane_image(200.0F);
  int flips = 0;
  for (std::size_t at = 0; at < SceneStore::kHeaderBytes + second.size(); ++at) {
    if (at >= 24 && at < SceneStore::kHeaderBytes) continue;  // behind the header's words: not used
    TestStorage storage;
    control::SceneView view;
    SceneStore store(storage);
    ASSERT_EQ(upload(store, first, view), StoreStatus::kOk);
    ASSERT_EQ(upload(store, second, view), StoreStatus::kOk);
    storage.at(1, at) ^= std::byte{0x10};
    SceneStore after(storage);
    ASSERT_EQ(after.open(view), StoreStatus::kOk) << at;
    EXPECT_EQ(after.image_crc(), crc32(first)) << at;
    ++flips;
  }
  std::printf("%d single-bit errors, each found\n", flips);
}

TEST(SceneStore, SequenceNumbersWrap) {
  TestStorage storage;
  control::SceneView view;
  SceneStore store(storage);
  ASSERT_EQ(upload(store, plane_image(1.0F), view), StoreStatus::kOk);
  // Age the slot to the end of the numbers, as four thousand million uploads would.
  const std::uint32_t header[5] = {0x53494854U, 1U, 0xFFFFFFFFU,
                                   static_cast<std::uint32_t>(plane_image(1.0F).size()),
                                   crc32(plane_image(1.0F))};
  const std::uint32_t header_crc = crc32(std::as_bytes(std::span(header)));
  for (std::size_t i = 0; i < sizeof(header); ++i) storage.at(0, i) = std::as_bytes(std::span(header))[i];
  std::memcpy(&storage.at(0, sizeof(header)), &header_crc, sizeof(header_crc));
  SceneStore aged(storage);
  ASSERT_EQ(aged.open(view), StoreStatus::kOk);
  ASSERT_EQ(aged.sequence(), 0xFFFFFFFFU);
  ASSERT_EQ(upload(aged, plane_image(2.0F), view), StoreStatus::kOk);
  SceneStore after(storage);
  ASSERT_EQ(after.open(view), StoreStatus::kOk);
  EXPECT_EQ(after.image_crc(), crc32(plane_image(2.0F)));
  EXPECT_EQ(after.sequence(), 1U);
}

TEST(SceneStore, ResumesTheSameDownloadOnly) {
  const std::vector<std::byte> image = plane_image(500.0F);
  TestStorage storage;
  control::SceneView view;
  SceneStore store(storage);
  ASSERT_EQ(store.begin(image.size(), crc32(image)), StoreStatus::kOk);
  ASSERT_EQ(store.write(0, std::span(image).first(100)), StoreStatus::kOk);
  EXPECT_EQ(store.write(0, std::span(image).first(10)), StoreStatus::kWrongOffset);
  EXPECT_EQ(store.write(100, std::vector<std::byte>(image.size())), StoreStatus::kWrongOffset);
  EXPECT_EQ(store.verify(), StoreStatus::kIncomplete);
  EXPECT_EQ(store.commit(view), StoreStatus::kNoDownload);
  ASSERT_EQ(store.begin(image.size(), crc32(image)), StoreStatus::kOk);  // the link came back
  EXPECT_EQ(store.offset(), 100U);
  ASSERT_EQ(store.write(100, std::span(image).subspan(100)), StoreStatus::kOk);
  EXPECT_EQ(store.verify(), StoreStatus::kOk);
  EXPECT_EQ(store.commit(view), StoreStatus::kOk);

  ASSERT_EQ(store.begin(image.size(), 1), StoreStatus::kOk);
  ASSERT_EQ(store.write(0, std::span(image).first(100)), StoreStatus::kOk);
  ASSERT_EQ(store.begin(image.size(), 2), StoreStatus::kOk);
  EXPECT_EQ(store.offset(), 0U) << "another image begins at its beginning";
  EXPECT_EQ(store.begin(0, 0), StoreStatus::kTooLarge);
  EXPECT_EQ(store.begin(store.capacity() + 1, 0), StoreStatus::kTooLarge);
  EXPECT_FALSE(storage.overwritten);
}

// Truncated and bit-flipped images, their CRC right and wrong: refused, and the running scene is untouched.
TEST(SceneStore, BadImagesLeaveTheRunningSceneAlone) {
  Bench bench;
  bench.start();
  bench.move({0, 0, -0.002}, 400);
  bench.ticks(1000);
  const std::vector<std::byte> good = plane_image(300.0F);
  const std::uint32_t sequence = bench.controller->store().sequence();
  const float force_N = bench.force_N();
  int refused = 0;
  for (std::size_t length = 1; length < good.size(); ++length) {
    const auto status = bench.controller->load_scene(std::span(good).first(length));
    EXPECT_EQ(status, StoreStatus::kRefused) << length;
    ++refused;
  }
  control::SceneView view;
  SceneStore scratch(bench.storage);
  ASSERT_EQ(scratch.open(view), StoreStatus::kOk);
  int flipped = 0;
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit, ++flipped) {
    std::vector<std::byte> bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    ASSERT_EQ(scratch.begin(good.size(), crc32(good)), StoreStatus::kOk);
    ASSERT_EQ(scratch.write(0, bad), StoreStatus::kOk);
    EXPECT_EQ(scratch.verify(), StoreStatus::kWrongCrc) << bit;
    EXPECT_FALSE(scratch.downloading());
  }
  bench.tick();
  EXPECT_EQ(bench.mode(), Mode::kArmed);
  EXPECT_EQ(bench.shown().scene_sequence, sequence);
  EXPECT_EQ(bench.controller->store().sequence(), sequence);
  EXPECT_NEAR(bench.force_N(), force_N, 0.05F);
  std::printf("refused: %d truncated images, %d with a flipped bit; the force stays %.3f N\n", refused,
              flipped, static_cast<double>(bench.force_N()));
}

}  // namespace
}  // namespace thimble::test
