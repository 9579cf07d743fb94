// Records of 64 bytes in two slots of a Storage, each with a sequence number and a CRC. Journal and AuditLog are made of it. Called from the
// background.
//
// A record is appended where the slot is erased. When a slot is full the other one is erased, and filled in its turn. So power may fail
// after any byte: a torn record has a wrong CRC, its place is not used again, and the records before it are still there; a torn erase has
// hit the slot with the older records.
//
// Numbers follow each other without gaps, except where power has failed during an erase.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/store/storage.h"

namespace thimble::firmware {

inline constexpr std::size_t kRecordBytes = 64;
// Bytes 0 to 3: sequence number, never 0; the last four: CRC-32 of all before them. Both little-endian, and put by RecordSlots.
using RecordBytes = std::array<std::byte, kRecordBytes>;
inline constexpr std::size_t kRecordCrcAt = kRecordBytes - 4;

// Little-endian numbers of up to 4 bytes.
void put_word(RecordBytes& record, std::size_t at, std::uint32_t value, std::size_t size = 4) noexcept;
[[nodiscard]] std::uint32_t word_at(std::span<const std::byte> record, std::size_t at,
                                    std::size_t size = 4) noexcept;

class RecordSlots {
 public:
  // The two slots first_slot and first_slot + 1, which have one size.
  RecordSlots(Storage& storage, unsigned first_slot) noexcept
      : storage_(storage), first_(first_slot), active_(first_slot) {}

  // At start. The newest valid record; empty: there is none. O(slot).
  [[nodiscard]] std::span<const std::byte> open() noexcept;
  // Puts number and CRC into it. False: the hardware refused, or does not hold it; the record before it is still the newest. Erases a slot where prepare() had no chance to.
  [[nodiscard]] bool append(RecordBytes& record) noexcept;
  // With the motors off: erases the other slot when at most so many places of this one are free, because a flash may need a second for
  // it. The records of the other slot are then gone.
  void prepare(std::size_t places_free) noexcept;

  [[nodiscard]] std::size_t places() const noexcept { return places(active_); }  // of a slot
  // The number of the first record that is not older than this one, and of the oldest for 0. 0: there is none. O(slot).
  [[nodiscard]] std::uint32_t at_or_after(std::uint32_t sequence) const noexcept;
  // found[i]: the record from + i; empty where there is none. O(slot).
  void find(std::uint32_t from, std::span<std::span<const std::byte>> found) const noexcept;

 private:
  [[nodiscard]] std::size_t places(unsigned slot) const noexcept {
    return storage_.slot(slot).size() / kRecordBytes;
  }
  [[nodiscard]] std::span<const std::byte> place(unsigned slot, std::size_t index) const noexcept {
    return storage_.slot(slot).subspan(index * kRecordBytes, kRecordBytes);
  }
  [[nodiscard]] unsigned other() const noexcept { return 2 * first_ + 1 - active_; }
  [[nodiscard]] bool erase_other() noexcept;
  template <class Visit>
  void visit_places(Visit&& visit) const noexcept;

  Storage& storage_;
  unsigned first_;
  unsigned active_;
  std::size_t next_ = 0;  // place of the next record in the active slot
  bool active_has_newest_ = true;
  bool other_erased_ = false;
  std::uint32_t sequence_ = 0;  // of the newest record; 0: none
};

}  // namespace thimble::firmware
