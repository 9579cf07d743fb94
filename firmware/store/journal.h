// The journal: records in two slots (record_slots.h), of which the newest valid one counts. Called from the background.
//
// Wear. Records come at most twice in kLeastInterval_s (PersistentState::due()), besides one for each start and each upload, which erases
// a slot of its own:
//
//   2 x 86400 s / 5 s / 32 records a slot = 1080 erases a day of both slots together, of an arm that is armed and disarmed all day
//
// That is 540 for each slot: an EEPROM that bears 1e6 writes lasts 5 years of it. A flash with sectors of 64 KiB (1024 records) has 34.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/core/motors_heat.h"
#include "firmware/store/record_slots.h"

namespace thimble::firmware {

// What survives a restart. CRCs: of the contents of a slot; 0: none.
struct JournalRecord {
  std::uint32_t utc_s =
      0;  // the heat is this at that time, or less: seconds since 1970; 0: the time is not known
  bool motors_on = false;    // the heat may have grown since
  bool on_trial = true;      // what is in use has not run for kTrial_s yet
  std::uint8_t crashes = 0;  // in a row, of the starts before this one
  std::uint16_t starts = 0;  // so far, this one included; wraps
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
  static constexpr float kLeastInterval_s = 5.0F;
  static constexpr std::size_t kMostErasesADay = 2 * 86400 / 5 / (Storage::kJournalSlotBytes / kRecordBytes);

  explicit Journal(Storage& storage) noexcept : slots_(storage, Storage::kFirstJournalSlot) {}

  // At start: the newest valid record. Nothing: there is none. O(slot).
  [[nodiscard]] std::optional<JournalRecord> open() noexcept;
  // As RecordSlots::append().
  [[nodiscard]] bool append(const JournalRecord& record) noexcept;
  // With the motors off: erases the other slot when this one is half full.
  void prepare() noexcept { slots_.prepare(slots_.places() / 2 - 1); }

 private:
  RecordSlots slots_;
};

}  // namespace thimble::firmware
