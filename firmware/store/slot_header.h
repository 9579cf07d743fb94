// Two slots that are written alternately, each with a header of sequence number and CRC-32 that is written last. So power
// may fail at any byte of a write, and what was saved before is still there. Used by the stores, in the background.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/pauses.h"
#include "firmware/link/crc32.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

using link::crc32;
// The same of many bytes, with a pause after every kilobyte (pause may be null).
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, control::Pause pause) noexcept;

// In front of the contents of each slot; a multiple of 8, so that they stay aligned.
inline constexpr std::size_t kSlotHeaderBytes = 64;

enum class SlotMagic : std::uint32_t {
  kScene = 0x53494854,
  kParams = 0x50494854,
  kKey = 0x4B494854,
  kArm = 0x41494854
};  // "THIS", "THIP", "THIK", "THIA"
// Of the slots that do not hold records.
[[nodiscard]] constexpr SlotMagic slot_magic(unsigned index) noexcept {
  if (index < Storage::kSceneSlots) return SlotMagic::kScene;
  if (index < Storage::kFirstJournalSlot) return SlotMagic::kParams;
  return index < Storage::kFirstArmSlot ? SlotMagic::kKey : SlotMagic::kArm;
}

struct SlotHeader {
  std::uint32_t sequence = 0;  // never 0 in a slot; wraps
  std::uint32_t length = 0;    // of the contents
  std::uint32_t crc = 0;       // of the contents
};
using SlotHeaderBytes = std::array<std::byte, 24>;

[[nodiscard]] SlotHeaderBytes encode(SlotMagic magic, const SlotHeader& header) noexcept;
// False: no sound header of this kind, or one whose contents would not fit the slot.
[[nodiscard]] bool decode(std::span<const std::byte> slot, SlotMagic magic, SlotHeader& header) noexcept;

[[nodiscard]] constexpr std::uint32_t next_sequence(std::uint32_t sequence) noexcept {
  return sequence + 1 == 0 ? 1 : sequence + 1;
}

// Which of slots first_slot and first_slot + 1 are whole (header and CRC), the newest first. O(contents).
struct NewestFirst {
  struct Found {
    unsigned slot = 0;
    SlotHeader header;
  };
  std::array<Found, 2> slot;
  std::size_t count = 0;
  // A header that is broken, or contents of the newest that are not what its header says. (An interrupted save leaves older contents
  // broken, or no header.)
  bool damaged = false;
};
[[nodiscard]] NewestFirst newest_first(const Storage& storage, unsigned first_slot, SlotMagic magic,
                                       control::Pause pause = nullptr) noexcept;

}  // namespace thimble::firmware
