// The journal: the newest record survives power that fails at any byte, and erases are as few as journal.h says.
#include "firmware/store/journal.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <optional>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using firmware::Journal;
using firmware::JournalRecord;
using firmware::Storage;

constexpr std::size_t kPlaces = Storage::kJournalSlotBytes / firmware::kRecordBytes;

JournalRecord numbered(std::uint32_t number) {
  JournalRecord record;
  record.utc_s = number;
  record.motors_on = number % 2 != 0;
  record.on_trial = number % 3 != 0;
  record.crashes = static_cast<std::uint8_t>(number);
  record.used = {number + 1, number + 2};
  record.set_aside = {number + 3, number + 4};
  record.proven = {number + 5, number + 6};
  for (auto& arm : record.heat)
    for (auto& motor : arm) motor = {0.5F * static_cast<float>(number % 100), 0.25F};
  return record;
}

void expect_equal(const JournalRecord& is, const JournalRecord& expected) {
  EXPECT_EQ(is.utc_s, expected.utc_s);
  EXPECT_EQ(is.motors_on, expected.motors_on);
  EXPECT_EQ(is.on_trial, expected.on_trial);
  EXPECT_EQ(is.crashes, expected.crashes);
  for (const auto member : {&JournalRecord::used, &JournalRecord::set_aside, &JournalRecord::proven}) {
    EXPECT_EQ((is.*member).scene, (expected.*member).scene);
    EXPECT_EQ((is.*member).params, (expected.*member).params);
  }
  for (std::size_t i = 0; i < is.heat.size(); ++i) {
    for (std::size_t j = 0; j < is.heat[i].size(); ++j) {
      EXPECT_EQ(is.heat[i][j].winding_K, expected.heat[i][j].winding_K);
      EXPECT_EQ(is.heat[i][j].housing_K, expected.heat[i][j].housing_K);
    }
  }
}

TEST(Journal, GivesTheNewestRecordBackAfterAnyNumber) {
  TestStorage storage;
  for (std::uint32_t number = 0; number < 3 * kPlaces; ++number) {
    Journal journal(storage);
    const std::optional<JournalRecord> found = journal.open();
    ASSERT_EQ(found.has_value(), number != 0);
    if (found) expect_equal(*found, numbered(number - 1));
    ASSERT_TRUE(journal.append(numbered(number)));
  }
  EXPECT_FALSE(storage.overwritten);
}

TEST(Journal, NeverStoresLessHeatThanThereIs) {
  TestStorage storage;
  JournalRecord record;
  record.heat[1][2] = {61.2345F, 0.0001F};
  ASSERT_TRUE(Journal(storage).append(record));
  const std::optional<JournalRecord> found = Journal(storage).open();
  ASSERT_TRUE(found);
  EXPECT_GE(found->heat[1][2].winding_K, 61.2345F);
  EXPECT_LE(found->heat[1][2].winding_K, 61.2345F + 1.0F / 64);
  EXPECT_GT(found->heat[1][2].housing_K, 0.0F);
}

// Also of a storage that is full of zeros at first, of one that erases downwards, and with prepare() in between.
TEST(Journal, SurvivesPowerLossAtEveryByte) {
  std::size_t losses = 0;
  for (const bool downwards : {false, true}) {
    for (const bool prepares : {false, true}) {
      // The records around the end of a slot: an append of a place, and one that erases.
      for (const std::size_t before : {std::size_t{1}, kPlaces / 2, kPlaces - 1, kPlaces, 2 * kPlaces}) {
        TestStorage filled;
        for (unsigned slot = Storage::kFirstJournalSlot; slot < Storage::kFirstAuditSlot; ++slot)
          for (std::size_t i = 0; i < Storage::kJournalSlotBytes; ++i) filled.at(slot, i) = std::byte{0};
        for (std::size_t i = 1; i <= before; ++i) {
          Journal journal(filled);
          static_cast<void>(journal.open());
          ASSERT_TRUE(journal.append(numbered(static_cast<std::uint32_t>(i))));
        }
        for (std::size_t power = 0;; ++power) {
          TestStorage storage = filled;
          storage.erase_downwards = downwards;
          storage.power_left = power;
          {
            Journal journal(storage);
            ASSERT_TRUE(journal.open());
            const bool kept = journal.append(numbered(9999));
            if (prepares) journal.prepare();
            if (kept && storage.power_left != 0) break;  // it needed no more
          }
          ++losses;
          storage.power_left = std::numeric_limits<std::size_t>::max();
          Journal journal(storage);
          const std::optional<JournalRecord> found = journal.open();
          ASSERT_TRUE(found) << before << " records, power for " << power << " bytes";
          expect_equal(*found, numbered(found->utc_s == 9999 ? 9999 : static_cast<std::uint32_t>(before)));
          // And it goes on.
          for (std::uint32_t i = 0; i < 2; ++i) ASSERT_TRUE(journal.append(numbered(20000 + i)));
          const std::optional<JournalRecord> next = Journal(storage).open();
          ASSERT_TRUE(next);
          expect_equal(*next, numbered(20001));
          ASSERT_FALSE(storage.overwritten);
        }
      }
    }
  }
  std::printf("[ figure   ] losses of power: %zu\n", losses);
}

// Every write of one slot fails: the newest record is not erased to make room.
TEST(Journal, KeepsTheNewestRecordWhenAStorageRefuses) {
  TestStorage storage;
  Journal journal(storage);
  ASSERT_FALSE(journal.open());
  for (std::uint32_t i = 1; i <= kPlaces; ++i) ASSERT_TRUE(journal.append(numbered(i)));
  ASSERT_TRUE(storage.erase(Storage::kFirstJournalSlot + 1, Storage::kJournalSlotBytes));
  for (std::size_t i = 0; i < 3 * kPlaces; ++i) {
    storage.power_left = 10;  // of a record of 64 bytes
    EXPECT_FALSE(journal.append(numbered(777)));
    journal.prepare();
    const std::optional<JournalRecord> found = Journal(storage).open();
    ASSERT_TRUE(found) << i;
    expect_equal(*found, numbered(kPlaces));
  }
}

}  // namespace
}  // namespace thimble::test
