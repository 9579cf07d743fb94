#include "firmware/store/audit_log.h"

#include <algorithm>

namespace thimble::firmware {
namespace {

using link::AuditEvent;
using link::AuditRecord;

// An entry in the store is the message, and behind it the room that was left.
constexpr std::size_t kAuditBytes = link::wire_size<AuditRecord>();
constexpr std::size_t kUtcAt = 8, kRoomAt = kRecordCrcAt - 1;
static_assert(kAuditBytes <= kRoomAt && AuditLog::kBurst < 256);

// Room that is kept from it. The less, the more an entry of it matters.
unsigned kept_from(AuditEvent event) noexcept {
  switch (event) {
    case AuditEvent::kParameter:
    case AuditEvent::kScene:
    case AuditEvent::kTimeTold:
    case AuditEvent::kUploadRefused:
    case AuditEvent::kProofRefused:
      return AuditLog::kKeptFromFrequent;
    case AuditEvent::kArmed:
    case AuditEvent::kDisarmed:
    case AuditEvent::kHoming:
    case AuditEvent::kMove:
    case AuditEvent::kSaved:
    case AuditEvent::kFault:
    case AuditEvent::kCleared:
      return AuditLog::kKeptForRare;
    case AuditEvent::kStart:
    case AuditEvent::kRestart:
    case AuditEvent::kArmImage:
    case AuditEvent::kKeySet:
    case AuditEvent::kKeyRemoved:
      return 0;
  }
  return AuditLog::kKeptFromFrequent;
}

bool alike(const AuditRecord& a, const AuditRecord& b) noexcept {
  return a.event == b.event && a.host == b.host && a.detail == b.detail && a.value == b.value &&
         a.text == b.text;
}

}  // namespace

void AuditLog::open(std::uint16_t start) noexcept {
  start_ = start;
  const std::span<const std::byte> newest = slots_.open();
  if (newest.empty()) return;
  room_ = std::min(kBurst, std::to_integer<unsigned>(newest[kRoomAt]));
  before_utc_s_ = word_at(newest, kUtcAt);
}

void AuditLog::refill(Time now) noexcept {
  std::uint32_t more = (now.uptime_s - room_since_s_) / kInterval_s;
  room_since_s_ += more * kInterval_s;
  if (before_utc_s_ != 0 && now.utc_s != 0) {
    const std::uint32_t start_s = now.utc_s - now.uptime_s;
    if (start_s > before_utc_s_) more += (start_s - before_utc_s_) / kInterval_s;
    before_utc_s_ = 0;
  }
  room_ = more < kBurst ? std::min(kBurst, room_ + static_cast<unsigned>(more)) : kBurst;
  if (room_ == kBurst) room_since_s_ = now.uptime_s;
}

bool AuditLog::may_write(const AuditRecord& event) const noexcept {
  return !finishing_ && room_ > kept_from(event.event);
}

bool AuditLog::repeats_last(const AuditRecord& event, Time now) const noexcept {
  return alike(event, last_) && now.uptime_s - last_.uptime_s < kInterval_s;
}

void AuditLog::hold(const AuditRecord& event) noexcept {
  if (held_) ++left_out_;
  if (!held_ || kept_from(event.event) <= kept_from(held_->event)) held_ = event;
}

void AuditLog::write_held() noexcept {
  --room_;
  held_->left_out = left_out_;
  RecordBytes bytes{};
  static_cast<void>(link::encode(*held_, {reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()}));
  bytes[kRoomAt] = static_cast<std::byte>(room_);
  if (!slots_.append(bytes)) return;
  left_out_ = 0;
  last_ = *held_;
  held_.reset();
}

void AuditLog::write_what_may(Time now) noexcept {
  if (held_ && may_write(*held_) && !repeats_last(*held_, now)) write_held();
}

void AuditLog::add(AuditRecord&& event, Time now) noexcept {
  refill(now);
  event.start = start_;
  event.utc_s = now.utc_s;
  event.uptime_s = now.uptime_s;
  if (held_ && !alike(*held_, event) && may_write(*held_)) write_held();
  hold(event);
  write_what_may(now);
}

void AuditLog::poll(Time now, bool motors_off) noexcept {
  refill(now);
  if (motors_off) slots_.prepare(slots_.places() / 8);
  write_what_may(now);
}

bool AuditLog::finish(Time now) noexcept {
  refill(now);
  if (!held_) return true;
  finishing_ = true;
  if (room_ == 0) return false;
  write_held();
  return true;
}

void AuditLog::read(std::uint32_t from, link::ByteWriter& out) const noexcept {
  const std::uint32_t first = slots_.at_or_after(from);
  if (first == 0) return;
  std::array<std::span<const std::byte>, kPage> found{};
  slots_.find(first, found);
  for (const std::span<const std::byte> entry : found)
    for (const std::byte byte : entry.first(std::min(entry.size(), kAuditBytes)))
      out.put(std::to_integer<std::uint8_t>(byte));
}

}  // namespace thimble::firmware
