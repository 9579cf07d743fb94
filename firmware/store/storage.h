// What a board keeps over power-off, as slots: flash, EEPROM, a file, or memory. Called from the background only,
// but what is mapped is read by the tick, in place.
//
//   slots 0, 1   scenes (firmware/store/scene_store.h): both have one size, the board's choice
//   slots 2, 3   parameters (firmware/store/param_store.h): at least kParamSlotBytes each
//   slots 4, 5   the journal (firmware/store/journal.h): both have one size, at least kJournalSlotBytes
//   slots 6, 7   the audit record (firmware/store/audit_log.h): both have one size, at least kAuditSlotBytes
//   slots 8, 9   the access key: at least kKeySlotBytes each
//   slots 10, 11 the image of arm 0, and 12, 13 of arm 1 (firmware/store/arm_store.h): at least kArmSlotBytes each, or none where the board
//                has no room; then it works with its built-in arms only
//
// Slots 4 to 7 hold records (firmware/store/record_slots.h). They are written a record at a time, also while the arm is armed: a write of a
// record takes a few milliseconds at most. The others begin with a header (slot_header.h), which is written last. A slot that a store of
// an older version does not have is empty: it may hold anything but a valid header or record.
#pragma once

#include <cstddef>
#include <span>

namespace thimble::firmware {

class Storage {
 public:
  static constexpr unsigned kSceneSlots = 2;
  static constexpr unsigned kFirstJournalSlot = 4;
  static constexpr unsigned kFirstAuditSlot = 6;
  static constexpr unsigned kFirstKeySlot = 8;
  static constexpr unsigned kFirstArmSlot = 10;
  static constexpr unsigned kSlots = 14;
  static constexpr std::size_t kParamSlotBytes = 512;
  static constexpr std::size_t kJournalSlotBytes = 2048;
  static constexpr std::size_t kAuditSlotBytes = 4096;
  static constexpr std::size_t kKeySlotBytes = 256;
  static constexpr std::size_t kArmSlotBytes = 8192;

  // The least size of a slot, where the board's scenes have this one.
  [[nodiscard]] static constexpr std::size_t slot_bytes(unsigned index, std::size_t scene_bytes) noexcept {
    if (index < kSceneSlots) return scene_bytes;
    if (index < kFirstJournalSlot) return kParamSlotBytes;
    if (index < kFirstAuditSlot) return kJournalSlotBytes;
    if (index < kFirstKeySlot) return kAuditSlotBytes;
    return index < kFirstArmSlot ? kKeySlotBytes : kArmSlotBytes;
  }
  [[nodiscard]] static constexpr bool holds_records(unsigned index) noexcept {
    return index >= kFirstJournalSlot && index < kFirstKeySlot;
  }

  // Slot contents in place: at least 8-byte aligned, at the same address and size for ever.
  [[nodiscard]] virtual std::span<const std::byte> slot(unsigned index) const noexcept = 0;

  // Makes the first `bytes` of a slot writable (at least; a flash rounds up to its sectors). May take long on
  // a flash; power may fail in the middle, and then the slot holds anything. False: the hardware refused.
  [[nodiscard]] virtual bool erase(unsigned index, std::size_t bytes) noexcept = 0;

  // True: what was written may be written again without an erase (an EEPROM). Then erase() may leave the older records of a slot that holds
  // records.
  [[nodiscard]] virtual bool overwrites() const noexcept { return false; }

  // Writes bytes that were erased and not written since. The stores write in ascending order, the slot's
  // header last; power may fail after any byte.
  [[nodiscard]] virtual bool write(unsigned index, std::size_t offset,
                                   std::span<const std::byte> bytes) noexcept = 0;

 protected:
  ~Storage() = default;
};

}  // namespace thimble::firmware
