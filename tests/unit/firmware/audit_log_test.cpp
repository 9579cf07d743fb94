// The audit record: the newest entries survive power that fails at any byte, every event has an entry or is counted, and a flood of events
// is as slow as audit_log.h says.
#include "firmware/store/audit_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "firmware/store/slot_header.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using firmware::Storage;

// The newest entries, of events `first_possible` and later, without a gap up to `last`.
void expect_newest(const AuditLog& log, std::uint32_t last, std::size_t at_least) {
  const std::vector<AuditRecord> entries = all(log);
  ASSERT_GE(entries.size(), at_least);
  ASSERT_LE(entries.size(), 2 * kSlot);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    ASSERT_EQ(entries[i].number, last + 1 - entries.size() + i);
    expect_event(entries[i], event_numbered(entries[i].number));
  }
}

TEST(AuditLog, KeepsTheNewestEntriesAtAnyTime) {
  for (const bool motors_off : {false, true}) {
    TestStorage storage;
    std::size_t least_kept = 2 * kSlot;
    for (std::uint32_t n = 1; n < 5 * kSlot; ++n) {
      AuditLog log(storage);
      log.open(static_cast<std::uint16_t>(n));
      add_calmly(log, n, n, motors_off);
      expect_newest(log, n, std::min<std::size_t>(n, motors_off ? kLeast : kSlot));
      if (n > 2 * kSlot) least_kept = std::min(least_kept, all(log).size());
    }
    EXPECT_FALSE(storage.overwritten);
    figure(motors_off ? "entries kept at least, motors off" : "entries kept at least, motors on",
           static_cast<double>(least_kept), "of 128 places");
  }
}

TEST(AuditLog, SaysWhenAndInWhichStart) {
  TestStorage storage;
  AuditLog(storage).open(7);
  AuditLog log(storage);
  log.open(513);
  log.add(event_numbered(1), {0, 5});
  log.add(event_numbered(2), {1'800'000'000, 25});
  const std::vector<AuditRecord> entries = all(log);
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].start, 513);
  EXPECT_EQ(entries[0].utc_s, 0U);
  EXPECT_EQ(entries[0].uptime_s, 5U);
  EXPECT_EQ(entries[1].utc_s, 1'800'000'000U);
  EXPECT_EQ(entries[1].uptime_s, 25U);
}

TEST(AuditLog, IsReadFromAnyNumberOn) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  EXPECT_TRUE(page(log, 0).empty());
  add_calmly(log, 1, 2 * kSlot + 10);
  const std::uint32_t oldest = all(log).front().number;
  for (const std::uint32_t from : {0U, 1U, oldest - 1, oldest, 0xFFFFFFFFU})
    EXPECT_EQ(page(log, from).front().number, oldest);
  for (const std::uint32_t from : {oldest + 1, oldest + 40, static_cast<std::uint32_t>(2 * kSlot + 10)})
    EXPECT_EQ(page(log, from).front().number, from);
  EXPECT_EQ(page(log, oldest).size(), AuditLog::kPage);
  EXPECT_TRUE(page(log, 2 * kSlot + 11).empty());
}

// Also over a storage of zeros, of an older version's contents, and with numbers that wrap.
TEST(AuditLog, BeginsInAStorageThatHoldsAnything) {
  Random random(5);
  for (const int fill : {0x00, 0x5A, -1}) {
    TestStorage storage;
    for (const unsigned slot : {6U, 7U})
      for (std::size_t i = 0; i < Storage::kAuditSlotBytes; ++i)
        storage.at(slot, i) =
            static_cast<std::byte>(fill < 0 ? random.below(256) : static_cast<std::uint64_t>(fill));
    AuditLog log(storage);
    log.open(1);
    EXPECT_TRUE(all(log).empty());
    add_calmly(log, 1, 3 * kSlot);
    expect_newest(log, 3 * kSlot, kSlot);
  }
}

TEST(AuditLog, NumbersMayWrap) {
  TestStorage storage;
  firmware::RecordBytes record{};
  firmware::put_word(record, 0, 0xFFFFFFF0);
  record[firmware::kRecordCrcAt - 1] = std::byte{AuditLog::kBurst};
  firmware::put_word(record, firmware::kRecordCrcAt,
                     firmware::crc32(std::span(record).first(firmware::kRecordCrcAt)));
  ASSERT_TRUE(storage.write(6, 0, record));
  AuditLog log(storage);
  log.open(1);
  add_calmly(log, 1, kSlot);
  const std::vector<AuditRecord> entries = all(log);
  ASSERT_EQ(entries.size(), kSlot + 1);
  for (std::size_t i = 1; i < entries.size(); ++i) EXPECT_EQ(entries[i].value, i);
}

// The records around the ends of slots; of a storage that erases upwards and downwards.
TEST(AuditLog, SurvivesPowerLossAtEveryByte) {
  std::size_t losses = 0;
  for (const bool downwards : {false, true}) {
    for (const bool prepares : {false, true}) {
      for (const std::size_t before :
           {std::size_t{1}, kLeast, kSlot - 1, kSlot, kSlot + 3, 2 * kSlot, 3 * kSlot}) {
        TestStorage filled;
        {
          AuditLog log(filled);
          log.open(1);
          add_calmly(log, 1, static_cast<std::uint32_t>(before));
        }
        // Every byte of a record, and one in 13 of an erase.
        for (std::size_t power = 0;; power += power < 2 * firmware::kRecordBytes ? 1 : 13) {
          TestStorage storage = filled;
          storage.erase_downwards = downwards;
          storage.power_left = power;
          const auto last = static_cast<std::uint32_t>(before + 1);
          {
            AuditLog log(storage);
            log.open(2);
            add_calmly(log, last, last, prepares);
            if (storage.power_left != 0) break;  // it needed no more
          }
          ++losses;
          storage.power_left = std::numeric_limits<std::size_t>::max();
          AuditLog log(storage);
          log.open(3);
          const std::vector<AuditRecord> entries = all(log);
          ASSERT_FALSE(entries.empty());
          const std::uint32_t newest = entries.back().number;
          ASSERT_TRUE(newest == before || newest == before + 1)
              << newest << " of " << before << ", power " << power << (downwards ? ", downwards" : "")
              << (prepares ? ", prepares" : "");
          // Where power failed during an erase, older entries are missing.
          for (const AuditRecord& entry : entries) expect_event(entry, event_numbered(entry.number));
          const std::size_t must = std::min(before, kLeast);
          ASSERT_GE(entries.size(), must);
          for (std::size_t i = 0; i < must; ++i)
            ASSERT_EQ(entries[entries.size() - 1 - i].number, newest - i);
          // And it goes on.
          log.add(event_numbered(777), {0, 100'000});
          log.add(event_numbered(778), {0, 200'000});
          const std::vector<AuditRecord> next = all(log);
          expect_event(next[next.size() - 2], event_numbered(777));
          expect_event(next.back(), event_numbered(778));
          EXPECT_EQ(next.back().number, newest + 2);
          ASSERT_FALSE(storage.overwritten);
        }
      }
    }
  }
  figure("losses of power", static_cast<double>(losses), "");
}

// Every write is torn, or every erase refused, for a while: what is there stays, and what has no entry is counted.
TEST(AuditLog, CountsWhatAStorageRefuses) {
  for (const bool at_the_end : {false, true}) {
    TestStorage storage;
    AuditLog log(storage);
    log.open(1);
    const std::uint32_t last = at_the_end ? kSlot : kSlot + 5;
    add_calmly(log, 1, last);
    for (std::uint32_t i = 1; i <= 20; ++i) {
      storage.power_left = 10;
      log.add(event_numbered(last + i), {0, (last + i) * kCalm_s});
      log.poll({0, (last + i) * kCalm_s}, true);
      EXPECT_EQ(all(log).back().number, last);
    }
    storage.power_left = std::numeric_limits<std::size_t>::max();
    log.poll({0, (last + 40) * kCalm_s}, true);
    const AuditRecord newest = all(log).back();
    EXPECT_EQ(newest.number, last + 1);
    expect_event(newest, event_numbered(last + 20));
    EXPECT_EQ(newest.left_out, 19U);
    EXPECT_GE(all(log).size(), std::min<std::size_t>(last, kLeast));
  }
}

// As an EEPROM: what is there may be written again, and an erase leaves it there.
class Overwritten final : public firmware::Storage {
 public:
  explicit Overwritten(std::byte filling) {
    for (auto& slot : slots_) slot.fill(filling);
  }
  std::span<const std::byte> slot(unsigned index) const noexcept override { return slots_[index]; }
  bool overwrites() const noexcept override { return true; }
  bool erase(unsigned, std::size_t) noexcept override { return true; }
  bool write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept override {
    std::ranges::copy(bytes, slots_[index].begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }

 private:
  std::array<std::array<std::byte, kAuditSlotBytes>, kSlots> slots_{};
};

TEST(AuditLog, KeepsTheNewestEntriesOfAStorageThatDoesNotErase) {
  Random random(7);
  for (const int filling : {0x00, 0x5A, 0xFF}) {
    Overwritten storage(static_cast<std::byte>(filling));
    for (std::uint32_t n = 1; n < 20 * kSlot;) {
      AuditLog log(storage);
      log.open(1);
      const auto more = static_cast<std::uint32_t>(random.below(40));
      add_calmly(log, n, n + more, random.below(2) == 0);
      n += more + 1;
      expect_newest(log, n - 1, std::min<std::size_t>(n - 1, 2 * kSlot));
      if (HasFatalFailure()) return;
    }
  }
}

// The judge knows the events alone. Each entry is of an event; the events between it and the one before it are as many as `left_out` says.
// An event may be left out behind one that is waiting and matters more.
int weight(const AuditRecord& event) {
  if (event.event == AuditEvent::kKeySet || event.event == AuditEvent::kRestart) return 2;
  return event.event == AuditEvent::kArmed || event.event == AuditEvent::kFault ? 1 : 0;
}

struct Judge {
  std::vector<AuditRecord> events;
  std::size_t seen = 0;  // events before it have an entry, or are counted
  std::uint32_t newest = 0;
  std::vector<std::uint32_t> written_s;

  void look(const AuditLog& log, std::uint32_t now_s) {
    for (const AuditRecord& entry : page(log, newest + 1)) {
      if (entry.number <= newest) continue;
      ASSERT_EQ(entry.number, newest + 1);
      newest = entry.number;
      const std::size_t end = seen + entry.left_out + 1;
      ASSERT_LE(end, events.size());
      std::size_t at = end - 1;
      while (at > seen && weight(events[at]) < weight(entry)) --at;
      expect_event(entry, events[at]);
      EXPECT_EQ(entry.uptime_s, events[at].uptime_s);
      seen = end;
      written_s.push_back(now_s);
    }
  }
};

TEST(AuditLog, EveryEventHasAnEntryOrIsCounted) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    TestStorage storage;
    AuditLog log(storage);
    log.open(1);
    Judge judge;
    std::uint32_t now_s = 0;
    const std::size_t pace = random.below(4);
    for (int step = 0; step < 1500; ++step) {
      now_s += static_cast<std::uint32_t>(pace == 0 ? random.below(2) == 0 : random.below(4 * pace * pace));
      storage.power_left = random.below(20) == 0 ? random.below(60) : std::numeric_limits<std::size_t>::max();
      if (random.below(3) == 0) {
        log.poll({0, now_s}, random.below(2) == 0);
      } else {
        AuditRecord event = event_numbered(static_cast<std::uint32_t>(random.below(3)));
        constexpr std::array kKinds = {AuditEvent::kParameter, AuditEvent::kScene,  AuditEvent::kArmed,
                                       AuditEvent::kFault,     AuditEvent::kKeySet, AuditEvent::kRestart};
        event.event = kKinds[random.below(kKinds.size())];
        event.value = static_cast<std::uint32_t>(random.below(2));
        event.uptime_s = now_s;
        judge.events.push_back(event);
        log.add(AuditRecord(event), {0, now_s});
      }
      judge.look(log, now_s);
      if (HasFatalFailure()) FAIL() << "seed " << seed << ", step " << step;
    }
    storage.power_left = std::numeric_limits<std::size_t>::max();
    log.poll({0, now_s + 1000}, true);
    judge.look(log, now_s + 1000);
    EXPECT_EQ(judge.seen, judge.events.size()) << "nothing waits any more";
    for (std::size_t i = 0; i < judge.written_s.size(); ++i)
      for (std::size_t j = i + AuditLog::kBurst + 1; j < judge.written_s.size(); ++j)
        ASSERT_LE(j - i,
                  AuditLog::kBurst + (judge.written_s[j] - judge.written_s[i]) / AuditLog::kInterval_s);
  }
}

}  // namespace
}  // namespace thimble::test
