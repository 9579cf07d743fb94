#include "board/mps2-an500/eeprom_storage.h"

#include <algorithm>

#include "firmware/store/slot_header.h"

namespace thimble::board {
namespace {

constexpr std::size_t kBankBytes = eeprom::kMostChips * eeprom::kChipBytes;
[[gnu::section(".slots")]] alignas(8) std::array<std::byte, kBankBytes> copies;

// Behind each scene: one slot of the key, of the audit record and of the journal.
constexpr std::size_t kBehindScene = firmware::Storage::kKeySlotBytes + firmware::Storage::kAuditSlotBytes +
                                     firmware::Storage::kJournalSlotBytes;
// In front of those, where there is more than one chip: one slot of each arm.
constexpr std::size_t kArms = (firmware::Storage::kSlots - firmware::Storage::kFirstArmSlot) / 2;
constexpr std::size_t kOfArms = kArms * firmware::Storage::kArmSlotBytes;

}  // namespace

EepromStorage::EepromStorage() noexcept {
  const std::size_t chips = eeprom::chips();
  if (chips == 0) return;
  has_arms_ = chips > 1;
  share_bytes_ = (chips * eeprom::kChipBytes - 2 * kParamSlotBytes) / kSceneSlots;
  for (unsigned i = 0; i < kSlots; ++i) {
    const std::span<std::byte> all = copy(i);
    std::ranges::fill(all, std::byte{0xFF});
    if (holds_records(i)) {
      static_cast<void>(eeprom::read(address(i), all));
      continue;
    }
    firmware::SlotHeader header;
    if (all.size() < firmware::kSlotHeaderBytes) continue;
    if (!eeprom::read(address(i), all.first(firmware::kSlotHeaderBytes)) ||
        !decode(all, firmware::slot_magic(i), header))
      continue;
    // Bytes that cannot be read lead to a wrong CRC.
    static_cast<void>(eeprom::read(address(i) + firmware::kSlotHeaderBytes,
                                   all.subspan(firmware::kSlotHeaderBytes, header.length)));
  }
}

// The slots behind the scenes are the ends of what was a scene's before they existed, the newest kind in front: so stores of then can be read.
std::size_t EepromStorage::address(unsigned index) const noexcept {
  if (!present()) return 0;
  if (index < kSceneSlots) return index * share_bytes_;
  if (index < kFirstJournalSlot) return kSceneSlots * share_bytes_ + (index - kSceneSlots) * kParamSlotBytes;
  const std::size_t end = (index % 2 + 1) * share_bytes_;
  if (index < kFirstAuditSlot) return end - kJournalSlotBytes;
  if (index < kFirstKeySlot) return end - kJournalSlotBytes - kAuditSlotBytes;
  if (index < kFirstArmSlot || !has_arms_) return end - kBehindScene;
  return end - kBehindScene - ((index - kFirstArmSlot) / 2 + 1) * kArmSlotBytes;
}

std::size_t EepromStorage::bytes(unsigned index) const noexcept {
  if (!present() || (index >= kFirstArmSlot && !has_arms_)) return 0;
  return slot_bytes(index, share_bytes_ - kBehindScene - (has_arms_ ? kOfArms : 0));
}

std::span<std::byte> EepromStorage::copy(unsigned index) const noexcept {
  return std::span(copies).subspan(address(index), bytes(index));
}

std::span<const std::byte> EepromStorage::slot(unsigned index) const noexcept { return copy(index); }

// An EEPROM needs no erasing. Only the invalid header has to be written, so the slot counts as empty after power-off.
bool EepromStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (!present() || bytes > copy(index).size()) return false;
  if (holds_records(index)) return true;
  std::ranges::fill(copy(index).first(bytes), std::byte{0xFF});
  return eeprom::write(address(index), copy(index).first(firmware::kSlotHeaderBytes));
}

bool EepromStorage::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (!present() || offset > copy(index).size() || bytes.size() > copy(index).size() - offset) return false;
  if (!eeprom::write(address(index) + offset, bytes)) return false;
  std::ranges::copy(bytes, copy(index).begin() + static_cast<std::ptrdiff_t>(offset));
  return true;
}

}  // namespace thimble::board
