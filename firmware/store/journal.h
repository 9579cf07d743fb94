// The journal: small records in two slots, of which the newest valid one counts. Called from the background.
//
// A record is appended where the slot is erased. When a slot is full the other one is erased, and filled in its turn. So power may fail
// after any byte: a torn record has a wrong CRC, its place is not used again, and the record before it is still there; a torn erase has
// hit the slot with the older records.
//
// Wear. Records come at most twice in kLeastInterval_s (PersistentState::due()), besides one for each start and each upload, which erases
// a slot of its own:
//
//   2 x 86400 s / 5 s / 64 records a slot = 540 erases a day of both slots together, of an arm that is armed and disarmed all day
//
// That is 270 for each slot: an EEPROM that bears 1e6 writes lasts 10 years of it. A flash with sectors of 64 KiB (1024 records) has 34.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/core/motors_heat.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

// What survives a restart. CRCs: of the contents of a slot; 0: none.
struct JournalRecord {
  std::uint32_t utc_s =
      0;  // the heat is this at that time, or less: seconds since 1970; 0: the time is not known
  bool motors_on = false;    // the heat may have grown since
  bool on_trial = true;      // what is in use has not run for kTrial_s yet
  std::uint8_t crashes = 0;  // in a row, of the starts before this one
  struct InUse {
    std::uint32_t scene = 0;
    std::uint32_t params = 0;
  };
  InUse used;       // by this start
  InUse set_aside;  // because it crashed
  InUse proven;     // it has run for kTrial_s
  MotorsHeat heat{};
};

class Journal {
 public:
  static constexpr std::size_t kRecordBytes = 64;
  static constexpr float kLeastInterval_s = 5.0F;
  static constexpr std::size_t kMostErasesADay = 2 * 86400 / 5 / (Storage::kJournalSlotBytes / kRecordBytes);

  explicit Journal(Storage& storage) noexcept : storage_(&storage) {}

  // At start: the newest valid record. Nothing: there is none. O(slot).
  [[nodiscard]] std::optional<JournalRecord> open() noexcept;
  // False: the hardware refused; the record before it is still the newest. Erases a slot where prepare() had no chance to.
  [[nodiscard]] bool append(const JournalRecord& record) noexcept;
  [[nodiscard]] std::uint32_t sequence() const noexcept {
    return sequence_;
  }  // of the newest record; 0: none
  // With the motors off: erases the other slot before this one is full, because a flash may need a second for it.
  void prepare() noexcept;

 private:
  [[nodiscard]] std::size_t places(unsigned slot) const noexcept {
    return storage_->slot(slot).size() / kRecordBytes;
  }
  [[nodiscard]] std::span<const std::byte> place(unsigned slot, std::size_t index) const noexcept {
    return storage_->slot(slot).subspan(index * kRecordBytes, kRecordBytes);
  }
  [[nodiscard]] unsigned other() const noexcept { return 2 * Storage::kFirstJournalSlot + 1 - active_; }
  [[nodiscard]] bool erase_other() noexcept;

  Storage* storage_;
  unsigned active_ = Storage::kFirstJournalSlot;
  std::size_t next_ = 0;  // place of the next record in the active slot
  bool active_has_newest_ = true;
  bool other_erased_ = false;
  std::uint32_t sequence_ = 0;  // of the newest record; 0: none
};

}  // namespace thimble::firmware
