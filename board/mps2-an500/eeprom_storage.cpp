#include "board/mps2-an500/eeprom_storage.h"

#include <algorithm>

#include "firmware/store/slot_header.h"

namespace thimble::board {
namespace {

constexpr std::size_t kBankBytes = eeprom::kMostChips * eeprom::kChipBytes;
[[gnu::section(".slots")]] alignas(8) std::array<std::byte, kBankBytes> copies;

constexpr firmware::SlotMagic magic_of(unsigned index) {
  return index < firmware::Storage::kSceneSlots ? firmware::SlotMagic::kScene : firmware::SlotMagic::kParams;
}

}  // namespace

EepromStorage::EepromStorage() noexcept {
  const std::size_t chips = eeprom::chips();
  if (chips == 0) return;
  scene_slot_bytes_ = (chips * eeprom::kChipBytes - 2 * kParamSlotBytes) / kSceneSlots;
  for (unsigned i = 0; i < kSlots; ++i) {
    const std::span<std::byte> all = copy(i);
    std::ranges::fill(all, std::byte{0xFF});
    firmware::SlotHeader header;
    if (!eeprom::read(address(i), all.first(firmware::kSlotHeaderBytes)) || !decode(all, magic_of(i), header))
      continue;
    // Bytes that cannot be read lead to a wrong CRC.
    static_cast<void>(eeprom::read(address(i) + firmware::kSlotHeaderBytes,
                                   all.subspan(firmware::kSlotHeaderBytes, header.length)));
  }
}

std::size_t EepromStorage::address(unsigned index) const noexcept {
  return index < kSceneSlots ? index * scene_slot_bytes_
                             : kSceneSlots * scene_slot_bytes_ + (index - kSceneSlots) * kParamSlotBytes;
}

std::span<std::byte> EepromStorage::copy(unsigned index) const noexcept {
  return std::span(copies).subspan(address(index), index < kSceneSlots ? scene_slot_bytes_ : kParamSlotBytes);
}

std::span<const std::byte> EepromStorage::slot(unsigned index) const noexcept { return copy(index); }

// An EEPROM needs no erasing. Only the invalid header has to be written, so the slot counts as empty after
// power-off.
bool EepromStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (!present() || bytes > copy(index).size()) return false;
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
