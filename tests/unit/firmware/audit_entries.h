// What the tests of the audit record put into it and read of it.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "firmware/store/audit_log.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {

namespace link = firmware::link;
using firmware::AuditLog;
using link::AuditEvent;
using link::AuditRecord;

inline constexpr std::uint32_t kCalm_s = AuditLog::kInterval_s;
inline constexpr std::size_t kSlot = firmware::Storage::kAuditSlotBytes / firmware::kRecordBytes;
inline constexpr std::size_t kLeast = AuditLog::least_kept(firmware::Storage::kAuditSlotBytes);

inline std::vector<AuditRecord> page(const AuditLog& log, std::uint32_t from) {
  std::array<std::uint8_t, link::kMaxPduBytes> bytes;
  link::ByteWriter out(bytes);
  log.read(from, out);
  EXPECT_FALSE(out.overflowed());
  constexpr std::size_t kEach = link::wire_size<AuditRecord>();
  EXPECT_EQ(out.size() % kEach, 0U);
  std::vector<AuditRecord> entries(out.size() / kEach);
  for (std::size_t i = 0; i < entries.size(); ++i)
    EXPECT_TRUE(link::decode(std::span<const std::uint8_t>(bytes).subspan(i * kEach, kEach), entries[i]));
  return entries;
}

inline std::vector<AuditRecord> all(const AuditLog& log) {
  std::vector<AuditRecord> entries = page(log, 0);
  while (!entries.empty()) {
    const std::vector<AuditRecord> more = page(log, entries.back().number + 1);
    if (more.empty()) break;
    entries.insert(entries.end(), more.begin(), more.end());
  }
  return entries;
}

inline AuditRecord event_numbered(std::uint32_t number) {
  AuditRecord event;
  event.event = AuditEvent::kFault;
  event.host = static_cast<std::uint8_t>(number);
  event.detail = static_cast<std::uint16_t>(number * 7);
  event.value = number;
  event.text = {'h', 'o', 's', 't', static_cast<std::uint8_t>('a' + number % 26)};
  return event;
}

inline void expect_event(const AuditRecord& is, const AuditRecord& event) {
  EXPECT_EQ(is.event, event.event);
  EXPECT_EQ(is.host, event.host);
  EXPECT_EQ(is.detail, event.detail);
  EXPECT_EQ(is.value, event.value);
  EXPECT_EQ(is.text, event.text);
}

// Entry by entry with time enough, so that each is written at once; event n has the number n.
inline void add_calmly(AuditLog& log, std::uint32_t first, std::uint32_t last, bool motors_off = false) {
  for (std::uint32_t n = first; n <= last; ++n) {
    log.add(event_numbered(n), {0, n * kCalm_s});
    log.poll({0, n * kCalm_s}, motors_off);
  }
}

// Of a controller, as a host reads it.
inline std::vector<AuditRecord> audit_page(Tester& host, std::uint32_t from) {
  const Bytes answer = host.ask(join({0x31, 0x03, 0x02, 0x0A}, big_endian({from})));
  EXPECT_GE(answer.size(), 4U);
  std::vector<AuditRecord> entries;
  constexpr std::size_t kEach = link::wire_size<AuditRecord>();
  for (std::size_t at = 4; at + kEach <= answer.size(); at += kEach)
    EXPECT_TRUE(link::decode(std::span(answer).subspan(at, kEach), entries.emplace_back()));
  return entries;
}

}  // namespace thimble::test
