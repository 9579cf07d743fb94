// The audit record: a ring of entries in two slots (record_slots.h) that say what was done with the arm, when, and by which host. Called
// from the background. firmware/services/audit.h says of what there is an entry.
//
// The newest entries survive: at least 7/8 of a slot (56 of 4096 bytes), at most two slots. The rest of an eighth is there because the other
// slot is erased early, with the motors off: a flash may need a second for it, in which the background would not hear a stop.
//
// Wear, and floods. There is room for kBurst entries, and for another one every kInterval_s. kKeptFromFrequent of them are kept from what a
// host can do all the time (parameters, scenes, the time), and kKeptForRare for starts, restarts, keys and arms' images alone. An event that repeats the
// last entry, its value included, waits kInterval_s for more of its kind. What has no room waits, too: of the waiting events one that matters
// most, the newest of those, gets an entry, which counts the others (`left_out`). So
//
//   (56 - kBurst) * kInterval_s = 480 s    is the least time in which a flood of events can replace all that a store of 4096 bytes keeps
//   86400 s / kInterval_s / 64 entries a slot = 90 erases a day of both slots together, 45 each
//
// A restart gives no new room, and is no way to be rid of what waits: it waits for it (finish()), so the figures hold for restarts, too. Only
// a loss of power or a crash forgets what waits. The time off gives room, where a clock tells it: the board's, or that of a host, which may lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/link/byte_writer.h"
#include "firmware/link/messages.h"
#include "firmware/store/record_slots.h"

namespace thimble::firmware {

class AuditLog {
 public:
  static constexpr unsigned kBurst = 24;
  static constexpr unsigned kKeptFromFrequent = 14;
  static constexpr unsigned kKeptForRare = 6;
  static constexpr std::uint32_t kInterval_s = 15;
  static constexpr std::size_t kPage = 32;  // entries that read() gives at most
  static constexpr std::size_t kMostErasesADay =
      86400 / kInterval_s / (Storage::kAuditSlotBytes / kRecordBytes);
  [[nodiscard]] static constexpr std::size_t least_kept(std::size_t slot_bytes) noexcept {
    const std::size_t places = slot_bytes / kRecordBytes;
    return places - places / 8;
  }

  struct Time {
    std::uint32_t utc_s = 0;  // since 1970; 0: not known
    std::uint32_t uptime_s = 0;
  };

  explicit AuditLog(Storage& storage) noexcept : slots_(storage, Storage::kFirstAuditSlot) {}

  // At start. The number of this start, for the entries. O(slot).
  void open(std::uint16_t start) noexcept;
  // An event with event, host, detail, value and text; the rest is filled in. It is written now, or in a later call, or counted.
  void add(link::AuditRecord&& event, Time now) noexcept;
  // Writes what waits; with the motors off prepares the next slot.
  void poll(Time now, bool motors_off) noexcept;
  // Before a restart, until it is true: nothing waits, or the storage refuses it. From the first call on it alone writes, so it is false for
  // kInterval_s at most, whatever is added meanwhile.
  [[nodiscard]] bool finish(Time now) noexcept;
  // Appends the entries from this number on, kPage at most; where that one is gone, or 0, from the oldest on. O(slot).
  void read(std::uint32_t from, link::ByteWriter& out) const noexcept;

 private:
  void refill(Time now) noexcept;
  [[nodiscard]] bool may_write(const link::AuditRecord& event) const noexcept;
  [[nodiscard]] bool repeats_last(const link::AuditRecord& event, Time now) const noexcept;
  void hold(const link::AuditRecord& event) noexcept;
  void write_held() noexcept;
  void write_what_may(Time now) noexcept;

  RecordSlots slots_;
  std::uint16_t start_ = 0;
  unsigned room_ = kBurst;
  std::uint32_t room_since_s_ = 0;  // uptime at which room_ was right
  std::uint32_t before_utc_s_ = 0;  // of the last entry before this start; 0: not known, or counted already
  link::AuditRecord last_{};        // entry that was written last since start
  std::optional<link::AuditRecord> held_;
  std::uint32_t left_out_ = 0;  // since the last entry, besides held_
  bool finishing_ = false;      // the next room is for finish()
};

}  // namespace thimble::firmware
