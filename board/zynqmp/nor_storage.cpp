#include "board/zynqmp/nor_storage.h"

#include <algorithm>

#include "board/zynqmp/board.h"
#include "firmware/store/slot_header.h"

namespace thimble::board {
namespace {

using firmware::Storage;

constexpr std::size_t kSmallSlotBytes = Nor::kSectorBytes;  // of all but the scenes
static_assert(kSmallSlotBytes >= Storage::kParamSlotBytes && kSmallSlotBytes >= Storage::kJournalSlotBytes &&
              kSmallSlotBytes >= Storage::kAuditSlotBytes && kSmallSlotBytes >= Storage::kKeySlotBytes &&
              kSmallSlotBytes >= Storage::kArmSlotBytes);
static_assert(kSceneSlotBytes % Nor::kSectorBytes == 0 && kStore % Nor::kSectorBytes == 0);

[[gnu::section(".slots")]] alignas(
    8) std::array<std::byte, Storage::kSceneSlots * kSceneSlotBytes +
                                 (Storage::kSlots - Storage::kSceneSlots) * kSmallSlotBytes> copies;

constexpr std::size_t begin_of(unsigned index) noexcept {
  return index < Storage::kSceneSlots
             ? index * kSceneSlotBytes
             : Storage::kSceneSlots * kSceneSlotBytes + (index - Storage::kSceneSlots) * kSmallSlotBytes;
}
std::uint32_t address_of(unsigned index) noexcept {
  return kStore + static_cast<std::uint32_t>(begin_of(index));
}

}  // namespace

NorStorage::NorStorage(Nor& nor) noexcept : nor_(nor) {
  for (unsigned i = 0; i < kSlots; ++i) {
    const std::span<std::byte> all = copy(i);
    // Bytes that cannot be read lead to a missing header or a wrong CRC.
    if (holds_records(i)) {
      erased_[i] = all.size();  // what is not written yet
      std::ranges::fill(all, std::byte{0xFF});
      static_cast<void>(nor_.read(address_of(i), all));
      continue;
    }
    const auto header_bytes = all.first(firmware::kSlotHeaderBytes);
    std::ranges::fill(header_bytes, std::byte{0xFF});
    firmware::SlotHeader header;
    if (nor_.read(address_of(i), header_bytes) && decode(all, firmware::slot_magic(i), header)) {
      static_cast<void>(nor_.read(address_of(i) + firmware::kSlotHeaderBytes,
                                  all.subspan(firmware::kSlotHeaderBytes, header.length)));
    }
  }
}

std::span<std::byte> NorStorage::copy(unsigned index) const noexcept {
  return std::span(copies).subspan(begin_of(index), index < kSceneSlots ? kSceneSlotBytes : kSmallSlotBytes);
}

std::span<const std::byte> NorStorage::slot(unsigned index) const noexcept { return copy(index); }

bool NorStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (!nor_.present() || bytes > copy(index).size()) return false;
  erased_[index] = 0;
  std::ranges::fill(copy(index).first(firmware::kSlotHeaderBytes), std::byte{0xFF});  // even if erasing fails
  if (!nor_.erase_sector(address_of(index))) return false;
  erased_[index] = Nor::kSectorBytes;
  return true;
}

bool NorStorage::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (!nor_.present() || offset > copy(index).size() || bytes.size() > copy(index).size() - offset)
    return false;
  while (erased_[index] < offset + bytes.size()) {
    if (!nor_.erase_sector(address_of(index) + static_cast<std::uint32_t>(erased_[index]))) return false;
    erased_[index] += Nor::kSectorBytes;
  }
  if (!nor_.write(address_of(index) + static_cast<std::uint32_t>(offset), bytes)) return false;
  std::ranges::copy(bytes, copy(index).begin() + static_cast<std::ptrdiff_t>(offset));
  return true;
}

}  // namespace thimble::board
