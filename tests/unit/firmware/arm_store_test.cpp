// The stored images of the arms: power lost at every byte of an upload, damage, the services that download one, and the arm that the
// controller has after the next start.
#include "firmware/store/arm_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "tests/unit/firmware/paddle_image.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using firmware::ArmStore;
using firmware::crc32;
using firmware::Storage;
using firmware::StoreStatus;

constexpr std::size_t kHeader = ArmStore::kHeaderBytes;

TEST(ArmStore, KeepsTheNewestOfEachArmOverARestart) {
  TestStorage storage;
  const auto a = paddle_image("a"), b = paddle_image("b"), c = paddle_image("c");
  {
    ArmStore store(storage);
    EXPECT_TRUE(store.image(0).empty());
    EXPECT_FALSE(store.damaged(0));
    for (const auto* image : {&a, &b, &c}) ASSERT_EQ(upload(store, 0, *image), StoreStatus::kOk);
    ASSERT_EQ(upload(store, 1, b), StoreStatus::kOk);
    EXPECT_TRUE(store.image(0).empty());  // the arm of this start stays
    EXPECT_EQ(store.stored_crc(0), crc32(c));
  }
  const ArmStore after(storage);
  EXPECT_TRUE(std::ranges::equal(after.image(0), c));
  EXPECT_TRUE(std::ranges::equal(after.image(1), b));
  EXPECT_FALSE(storage.overwritten);
}

TEST(ArmStore, SurvivesPowerLossAtEveryByte) {
  const auto first = paddle_image("first"), second = paddle_image("second"), third = paddle_image("third");
  int cuts = 0, new_one = 0, disarmed = 0;
  for (const bool downwards : {false, true}) {
    for (const bool both_slots_full : {false, true}) {
      for (std::size_t budget = 0;; ++budget) {
        TestStorage storage;
        storage.erase_downwards = downwards;
        ArmStore before(storage);
        ASSERT_EQ(upload(before, 1, first), StoreStatus::kOk);
        if (both_slots_full) {
          ASSERT_EQ(upload(before, 1, second), StoreStatus::kOk);
        }
        const std::uint32_t old_crc = before.stored_crc(1);
        storage.power_left = budget;
        const StoreStatus status = upload(before, 1, third);
        storage.power_left = std::numeric_limits<std::size_t>::max();

        ArmStore after(storage);
        ASSERT_EQ(after.image_crc(1), status == StoreStatus::kOk ? crc32(third) : old_crc) << budget;
        ASSERT_EQ(crc32(after.image(1)), after.image_crc(1)) << budget;
        ++cuts;
        disarmed += after.damaged(1) ? 1 : 0;
        new_one += after.image_crc(1) == old_crc ? 0 : 1;
        // And the store goes on working.
        ASSERT_EQ(upload(after, 1, second), StoreStatus::kOk) << budget;
        ASSERT_FALSE(ArmStore(storage).damaged(1)) << budget;
        EXPECT_FALSE(storage.overwritten);
        if (status == StoreStatus::kOk) break;
      }
    }
  }
  std::printf("%d cuts, %d times the new arm, %d times an upload is needed before arming\n", cuts, new_one,
              disarmed);
  EXPECT_EQ(new_one, 4);  // only the complete uploads
}

TEST(ArmStore, RefusesWhatIsNoArm) {
  TestStorage storage;
  ArmStore store(storage);
  EXPECT_EQ(upload(store, 0, paddle_image("a", false)), StoreStatus::kRefused);
  EXPECT_EQ(store.verdict(), firmware::ArmStatus::kNoDrive);
  EXPECT_EQ(store.commit(), StoreStatus::kNoDownload);
  EXPECT_EQ(store.begin(0, 0, 0), StoreStatus::kTooLarge);
  EXPECT_EQ(store.begin(0, Storage::kArmSlotBytes - kHeader + 1, 0), StoreStatus::kTooLarge);
  EXPECT_EQ(store.begin(firmware::kMaxArms, 100, 0), StoreStatus::kNoDownload);
  EXPECT_TRUE(ArmStore(storage).image(0).empty());
}

// Prepare, request, blocks, exit: the answer to the exit.
Bytes send(Tester& tester, const std::vector<std::byte>& image, std::uint8_t arm = 0) {
  const auto length = static_cast<std::uint32_t>(image.size());
  EXPECT_TRUE(tester.ok({0x10, 0x02}));
  EXPECT_TRUE(tester.ok(join({0x31, 0x01, 0x02, 0x0D, arm}, big_endian({length, crc32(image)}))));
  EXPECT_TRUE(tester.ok(join({0x34, 0x00, 0x44}, big_endian({0, length}))));
  Bytes data{0x36, 1};
  for (const std::byte byte : image) data.push_back(std::to_integer<std::uint8_t>(byte));
  EXPECT_TRUE(tester.ok(data));
  return tester.ask({0x37});
}

TEST(ArmStore, IsUploadedByServicesAndUsedFromTheNextStartOn) {
  Bench bench;
  const auto image = paddle_image("paddle");
  {
    Tester tester(bench);
    EXPECT_EQ(send(tester, image), Bytes{0x77});
    EXPECT_TRUE(tester.routine(0x020E));
    EXPECT_EQ(tester.text(link::kDidArmName), "premium-1.5");
    link::ArmImages images;
    ASSERT_TRUE(link::decode(tester.read(link::ArmImages::kId), images));
    EXPECT_EQ(images.crc[0], 0U);
    EXPECT_EQ(images.next_crc[0], crc32(image));
    EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x0E}), link::Nrc::kConditionsNotCorrect);
    EXPECT_EQ(tester.text(link::kDidRefusal), "no_download");
    tester.run(1000);
    const Bytes entries = tester.ask(join({0x31, 0x03, 0x02, 0x0A}, big_endian({0})));
    bool told = false;
    link::AuditRecord entry;
    for (std::size_t at = 4; at + link::wire_size<link::AuditRecord>() <= entries.size();
         at += link::wire_size<link::AuditRecord>())
      told = told || (link::decode(std::span(entries).subspan(at), entry) &&
                      entry.event == link::AuditEvent::kArmImage && entry.value == crc32(image));
    EXPECT_TRUE(told);
  }
  bench.restart("host");
  Tester tester(bench);
  EXPECT_EQ(tester.text(link::kDidArmName), "paddle");
  link::ArmImages images;
  ASSERT_TRUE(link::decode(tester.read(link::ArmImages::kId), images));
  EXPECT_EQ(images.crc[0], crc32(image));
  EXPECT_FALSE(images.damaged[0]);
  EXPECT_EQ(bench.controller->fault(), Fault::kNone);
}

TEST(ArmStore, UploadsAreRefusedWithAReason) {
  Bench bench;
  bench.start();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x02}));
  const Bytes prepare = join({0x31, 0x01, 0x02, 0x0D, 0}, big_endian({100, 0}));
  EXPECT_EQ(tester.refused(prepare), link::Nrc::kConditionsNotCorrect);
  EXPECT_EQ(tester.text(link::kDidRefusal), "wrong_mode");
  ASSERT_TRUE(tester.routine(0x0202));
  tester.run(2000);
  const Bytes no_such_arm = join({0x31, 0x01, 0x02, 0x0D, 1}, big_endian({100, 0}));
  EXPECT_EQ(tester.refused(no_such_arm), link::Nrc::kRequestOutOfRange);
  const Bytes large = join({0x31, 0x01, 0x02, 0x0D, 0}, big_endian({9000, 0}));
  EXPECT_EQ(tester.refused(large), link::Nrc::kDownloadNotAccepted);
  EXPECT_EQ(send(tester, paddle_image("a", false)),
            (Bytes{0x7F, 0x37, static_cast<std::uint8_t>(link::Nrc::kProgrammingFailure)}));
  EXPECT_EQ(tester.text(link::kDidRefusal), "no_drive");
}

// In header and contents, of one that is alone and of one with an older one beside it.
TEST(ArmStore, DamageIsAFaultAndKeepsTheArmFromArmingUntilTheNextUpload) {
  for (const int images : {1, 2}) {
    for (const std::size_t at : {std::size_t{8}, kHeader + 20}) {
      Bench bench;
      {
        ArmStore store(bench.storage);
        for (int i = 0; i < images; ++i)
          ASSERT_EQ(upload(store, 0, paddle_image(i == 0 ? "old" : "new")), StoreStatus::kOk);
      }
      bench.storage.at(Storage::kFirstArmSlot + static_cast<unsigned>(images - 1), at) ^= std::byte{4};
      bench.restart("power_on");
      EXPECT_EQ(bench.controller->fault(), Fault::store_corrupt);
      bench.tick();
      ASSERT_EQ(bench.controller->request(Command::kClear), 0U);
      bench.ticks(2);
      EXPECT_EQ(bench.controller->fault(), Fault::kNone);
      bench.load();
      bench.home();
      EXPECT_EQ(bench.controller->unmet(), firmware::kBoardLacks);
      EXPECT_EQ(bench.controller->request(Command::kArm), firmware::kBoardLacks);
      for (int i = 0; i < 100; ++i) {
        bench.tick();
        ASSERT_FALSE(any_enabled(bench.outputs) || any_current(bench.outputs));
      }

      ArmStore store(bench.storage);
      ASSERT_EQ(upload(store, 0, paddle_image("again")), StoreStatus::kOk);
      bench.restart("power_on");
      EXPECT_EQ(bench.controller->fault(), Fault::kNone);
      bench.ticks(2);
      EXPECT_EQ(bench.controller->unmet() & firmware::kBoardLacks, 0U);
    }
  }
}

// What is damaged stays known until another image is complete: neither the older one nor the built-in arm takes its place.
TEST(ArmStore, DamageOutlivesAnUploadThatIsBrokenOffAtAnyByte) {
  const auto again = paddle_image("again");
  int cuts = 0, new_one = 0;
  for (const int images : {1, 2, 3}) {
    for (const std::size_t at : {std::size_t{8}, kHeader + 20}) {
      for (const bool downwards : {false, true}) {
        for (std::size_t budget = 0;; ++budget) {
          TestStorage storage;
          storage.erase_downwards = downwards;
          {
            ArmStore store(storage);
            for (int i = 0; i < images; ++i)
              ASSERT_EQ(upload(store, 0, paddle_image(std::to_string(i))), StoreStatus::kOk);
          }
          storage.at(Storage::kFirstArmSlot + static_cast<unsigned>(images - 1) % 2, at) ^= std::byte{4};
          ArmStore store(storage);
          ASSERT_TRUE(store.damaged(0));
          storage.power_left = budget;
          const StoreStatus status = upload(store, 0, again);
          storage.power_left = std::numeric_limits<std::size_t>::max();

          const ArmStore after(storage);
          const bool has_it = after.image_crc(0) == crc32(again);
          ASSERT_TRUE(after.damaged(0) || has_it) << images << " images, byte " << at << ", cut " << budget;
          ++cuts;
          if (status != StoreStatus::kOk) continue;
          ASSERT_TRUE(has_it && !after.damaged(0));
          ++new_one;
          break;
        }
      }
    }
  }
  std::printf("%d cuts, %d complete\n", cuts, new_one);
  EXPECT_EQ(new_one, 12);
}

// Not of this firmware, or made by a program that does not check: its CRC is right.
TEST(ArmStore, ASoundImageOfNoArmIsDamage) {
  TestStorage storage;
  const auto image = paddle_image("a", false);
  const auto header = firmware::encode(firmware::SlotMagic::kArm,
                                       {1, static_cast<std::uint32_t>(image.size()), crc32(image)});
  ASSERT_TRUE(storage.write(Storage::kFirstArmSlot + 3, kHeader, image));
  ASSERT_TRUE(storage.write(Storage::kFirstArmSlot + 3, 0, header));
  ArmStore store(storage);
  EXPECT_FALSE(store.damaged(0));
  EXPECT_TRUE(store.damaged(1));
  EXPECT_TRUE(store.image(1).empty());
  ASSERT_EQ(upload(store, 1, paddle_image("b")), StoreStatus::kOk);
  EXPECT_FALSE(ArmStore(storage).damaged(1));
}

}  // namespace
}  // namespace thimble::test
