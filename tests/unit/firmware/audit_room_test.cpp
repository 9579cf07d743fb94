// How many entries there are for many events: each has one or is counted, what matters most has one, and a flood is as slow as audit_log.h
// says, also over restarts.
#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "tests/support/figure.h"
#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

TEST(AuditRoom, CalmEventsAreWrittenAtOnce) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  for (std::uint32_t n = 1; n <= AuditLog::kBurst - AuditLog::kKeptForRare; ++n) {
    log.add(event_numbered(n), {0, 0});
    EXPECT_EQ(all(log).size(), n);
  }
}

TEST(AuditRoom, ParametersLeaveRoomForTheRest) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  for (std::uint32_t n = 1; n <= 1000; ++n) {
    AuditRecord event = event_numbered(n);
    event.event = AuditEvent::kParameter;
    log.add(AuditRecord(event), {0, 0});
  }
  EXPECT_EQ(all(log).size(), AuditLog::kBurst - AuditLog::kKeptFromFrequent);
  log.add(event_numbered(1), {0, 0});
  const AuditRecord newest = all(log).back();
  expect_event(newest, event_numbered(1));
  EXPECT_EQ(newest.left_out, 1000 - (AuditLog::kBurst - AuditLog::kKeptFromFrequent));
}

TEST(AuditRoom, AnEventThatRepeatsWaitsForMoreOfItsKind) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  AuditRecord event = event_numbered(1);
  event.event = AuditEvent::kParameter;
  for (std::uint32_t i = 0; i < 50; ++i) log.add(AuditRecord(event), {0, 1});
  EXPECT_EQ(all(log).size(), 1U);
  log.poll({0, AuditLog::kInterval_s}, false);
  EXPECT_EQ(all(log).size(), 1U);
  log.poll({0, 1 + AuditLog::kInterval_s}, false);
  ASSERT_EQ(all(log).size(), 2U);
  EXPECT_EQ(all(log)[1].left_out, 48U);
}

// Events without a pause, of one kind after the other, with the motors off, for a day.
TEST(AuditRoom, AFloodIsAsSlowAsTheHeaderSays) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  const std::uint32_t calm = 2 * kSlot;
  add_calmly(log, 1, calm, true);
  const std::uint32_t start_s = (calm + AuditLog::kBurst) * kCalm_s;
  std::uint32_t lost_s = 0;
  const std::size_t before = storage.erases[6] + storage.erases[7];
  for (std::uint32_t s = 0; s < 86400; ++s) {
    for (std::uint32_t i = 0; i < 10; ++i) log.add(event_numbered(1000 + s * 10 + i), {0, start_s + s});
    log.poll({0, start_s + s}, true);
    if (lost_s == 0 && all(log).front().number > calm) lost_s = s;
  }
  const std::size_t erases = storage.erases[6] + storage.erases[7] - before;
  figure("s until nothing is left of what was there before a flood", lost_s, "");
  figure("erases a day", static_cast<double>(erases), "");
  EXPECT_GE(lost_s, (kLeast - AuditLog::kBurst) * AuditLog::kInterval_s);
  EXPECT_LE(erases, AuditLog::kMostErasesADay + 1);
  EXPECT_GT(all(log).back().left_out, 100U) << "it tells of those that it left out";
}

TEST(AuditRoom, RestartsGiveNoRoom) {
  constexpr unsigned kRoom = AuditLog::kBurst - AuditLog::kKeptForRare;
  TestStorage storage;
  std::uint32_t n = 0;
  const auto starts = [&](int count, AuditLog::Time now) {
    for (int i = 0; i < count; ++i) {
      AuditLog log(storage);
      log.open(1);
      for (int j = 0; j < 3; ++j) log.add(event_numbered(++n), now);
    }
  };
  const auto entries = [&] {
    AuditLog log(storage);
    log.open(1);
    return all(log).size();
  };
  starts(100, {1'800'000'000, 0});
  EXPECT_EQ(entries(), kRoom);
  // No clock tells how long it was off.
  starts(100, {0, 0});
  EXPECT_EQ(entries(), kRoom);
  starts(1, {1'800'000'000 + 2 * AuditLog::kInterval_s, 0});
  EXPECT_EQ(entries(), kRoom + 2);
  // A clock that goes backwards tells nothing.
  starts(100, {1'700'000'000, 0});
  EXPECT_EQ(entries(), kRoom + 2);
}

// The rare ones have room of their own, whatever floods the record: hosts that arm and disarm, faults, parameters.
TEST(AuditRoom, KeysArmsAndRestartsHaveEntriesInAFlood) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  const auto add = [&log](AuditEvent kind, std::uint32_t number) {
    AuditRecord event = event_numbered(number);
    event.event = kind;
    log.add(std::move(event), {0, 6});
  };
  for (std::uint32_t n = 1; n <= 14; ++n) {
    add(AuditEvent::kArmed, n);
    add(AuditEvent::kDisarmed, n);
  }
  constexpr std::array kRare = {AuditEvent::kKeySet, AuditEvent::kKeyRemoved, AuditEvent::kRestart,
                                AuditEvent::kArmImage};
  for (const AuditEvent kind : kRare) {
    add(kind, 1);
    add(AuditEvent::kParameter, 20);
    EXPECT_EQ(all(log).back().event, kind);
  }
  EXPECT_EQ(all(log)[all(log).size() - kRare.size()].left_out,
            28 - (AuditLog::kBurst - AuditLog::kKeptForRare));
}

// A restart leaves nothing behind, and gives no room: it waits for an entry for all that has none, also for what comes meanwhile.
TEST(AuditRoom, ARestartWaitsForWhatWaits) {
  TestStorage storage;
  std::uint32_t n = 0, entries = 0, counted = 0, newest = 0, total_s = 0;
  for (std::uint16_t start = 1; start <= 40; ++start) {
    AuditLog log(storage);
    log.open(start);
    for (int i = 0; i < 30; ++i) {
      AuditRecord event = event_numbered(++n);
      if (i == 29) event.event = AuditEvent::kRestart;
      log.add(std::move(event), {0, 0});
    }
    std::uint32_t now_s = 0;
    while (!log.finish({0, now_s})) log.add(event_numbered(++n), {0, ++now_s});
    EXPECT_LE(now_s, AuditLog::kInterval_s);
    total_s += now_s;
    for (const AuditRecord& entry : page(log, newest + 1)) {
      if (entry.number <= newest) continue;
      ++entries;
      counted += entry.left_out;
      newest = entry.number;
    }
    EXPECT_EQ(entries + counted, n) << start;
    EXPECT_EQ(all(log).back().event, AuditEvent::kRestart);
    EXPECT_LE(entries, AuditLog::kBurst + total_s / AuditLog::kInterval_s);
  }
}

TEST(AuditRoom, AStorageThatRefusesDoesNotHoldUpARestart) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  storage.power_left = 0;
  for (std::uint32_t n = 0; n < 2 * AuditLog::kBurst; ++n) log.add(event_numbered(n), {0, 0});
  std::uint32_t now_s = 0;
  while (!log.finish({0, now_s})) ASSERT_LE(++now_s, AuditLog::kInterval_s);
}

// The value is another one: the record would say the old one if power failed now.
TEST(AuditRoom, AnotherValueIsNoRepetition) {
  TestStorage storage;
  AuditLog log(storage);
  log.open(1);
  for (const std::uint32_t value : {5U, 19U, 19U}) {
    AuditRecord event = event_numbered(1);
    event.event = AuditEvent::kParameter;
    event.value = value;
    log.add(std::move(event), {0, 1});
  }
  ASSERT_EQ(all(log).size(), 2U);
  EXPECT_EQ(all(log).back().value, 19U);
}

// What a host does to hide it: it uses up the room, and restarts the board.
TEST(AuditRoom, ARestartHidesNothing) {
  Bench bench;
  bench.load();
  bench.home();
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  for (int i = 0; i < 14; ++i) {
    ASSERT_EQ(bench.controller->request(Command::kArm), 0) << i;
    bench.tick();
    ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
    for (int j = 0; j < 4; ++j) {
      host.run(400);
      host.post({0x3E, 0x80});
    }
  }
  ASSERT_TRUE(host.ok(join({0x31, 0x01, 0x02, 0x0B}, Bytes(link::kKeyBytes, 7))));
  ASSERT_TRUE(host.ok({0x31, 0x02, 0x02, 0x0B}));
  ASSERT_TRUE(host.routine(0x0207));
  bench.arm();  // so that the restart disarms, of which there is no entry yet
  ASSERT_TRUE(host.ok({0x11, 0x01}));
  const double asked_s = static_cast<double>(bench.inputs.time_us) * 1e-6;
  while (!bench.controller->take_reset()) {
    host.run(10);
    ASSERT_LT(static_cast<double>(bench.inputs.time_us) * 1e-6, asked_s + 2 * AuditLog::kInterval_s);
  }
  bench.restart("host");
  bench.for_testers.clear();
  bench.tick();
  Tester later(bench, false, 2);
  std::array<int, 32> seen{};
  std::uint32_t events = 0;
  for (const AuditRecord& entry : audit_page(later, 0)) {
    ++seen[static_cast<std::size_t>(entry.event)];
    events += 1 + entry.left_out;
  }
  for (const AuditEvent event : {AuditEvent::kKeySet, AuditEvent::kKeyRemoved, AuditEvent::kRestart})
    EXPECT_EQ(seen[static_cast<std::size_t>(event)], 1) << name(event);
  EXPECT_EQ(seen[static_cast<std::size_t>(AuditEvent::kStart)], 2);
  EXPECT_EQ(events, 1 + 2 * 15 + 2 + 1 + 1 + 1) << "start, armed and disarmed, key, saved, restart, start";
}

// There is no room, and a host goes on asking for it: a restart leaves nothing behind and is in time, also where the storage takes nothing.
TEST(AuditRoom, ARestartInAFloodWaitsOnceForRoom) {
  for (const bool broken : {false, true}) {
    Bench bench;
    Tester host(bench, false, 1);
    ASSERT_TRUE(host.ok({0x10, 0x03}));
    for (unsigned i = 0; i < AuditLog::kBurst; i += 2) {
      ASSERT_TRUE(host.ok(join({0x31, 0x01, 0x02, 0x0B}, Bytes(link::kKeyBytes, 7))));
      ASSERT_TRUE(host.ok({0x31, 0x02, 0x02, 0x0B}));
    }
    if (broken) bench.storage.power_left = 0;
    std::uint32_t asked = 0, ticks = 0;
    const auto most = static_cast<std::uint32_t>((AuditLog::kInterval_s + 1) / bench.config.period_s);
    for (; !bench.controller->take_reset(); ++ticks) {
      ASSERT_LT(ticks, most) << "broken " << broken;
      if (ticks % 400 == 0) host.post({0x11, 0x01}), ++asked;
      host.run(1);
    }
    EXPECT_GT(asked, 1U);
    if (broken) continue;
    bench.restart("host");
    bench.for_testers.clear();
    Tester later(bench, false, 2);
    std::uint32_t events = 0;
    for (const AuditRecord& entry : audit_page(later, 0)) events += 1 + entry.left_out;
    EXPECT_EQ(events, 1 + AuditLog::kBurst + asked) << "start, keys, restarts";
  }
}

// Anybody may write them.
TEST(AuditRoom, ParametersThatNoForceDependsOnHaveNoEntry) {
  Bench bench;
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  const std::size_t before = audit_page(host, 0).size();
  for (std::uint8_t i = 1; i <= 40; ++i) ASSERT_TRUE(host.ok({0x2E, 0x01, 0x70, i, 0, 0, 0}));
  ASSERT_TRUE(host.ok({0x2E, 0x01, 0x00, 0, 0, 0x80, 0x3F}));
  const std::vector<AuditRecord> entries = audit_page(host, 0);
  ASSERT_EQ(entries.size(), before + 1);
  EXPECT_EQ(entries.back().left_out, 0U);
}

}  // namespace
}  // namespace thimble::test
