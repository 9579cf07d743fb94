#include "firmware/store/param_store.h"

#include <algorithm>
#include <array>

#include "firmware/store/slot_header.h"

namespace thimble::firmware {
namespace {

// Each: id and value, little-endian, 4 bytes both. A list and no struct, so that parameters may come and go.
constexpr std::size_t kEntryBytes = 8;
constexpr bool persistent(const ParamRow& row) { return row.persistent == Persistence::kPersistent; }
constexpr std::size_t kSetBytes =
    static_cast<std::size_t>(std::count_if(kParamTable.begin(), kParamTable.end(), persistent)) * kEntryBytes;
static_assert(kSlotHeaderBytes + kSetBytes <= Storage::kParamSlotBytes);

void put(std::span<std::byte> at, std::uint32_t value) noexcept {
  for (std::size_t i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(value >> (8 * i));
}

std::uint32_t get(std::span<const std::byte> at) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(at[i]) << (8 * i);
  return value;
}

}  // namespace

void ParamStore::open() noexcept {
  const NewestFirst found = newest_first(*storage_, kFirstSlot, SlotMagic::kParams);
  damaged_ = found.damaged;
  if (found.count == 0) return;
  const auto& [slot, header] = found.slot[0];
  active_ = slot;
  sequence_ = header.sequence;
  crc_ = header.crc;
  length_ = header.length;
}

void ParamStore::apply(Params& params) const noexcept {
  const std::span<const std::byte> set =
      storage_->slot(active_).subspan(std::min(kSlotHeaderBytes, storage_->slot(active_).size()), length_);
  for (std::size_t at = 0; at + kEntryBytes <= set.size(); at += kEntryBytes) {
    const std::uint32_t id = get(set.subspan(at));
    const ParamRow* row = id <= 0xFFFF ? find_param(static_cast<std::uint16_t>(id)) : nullptr;
    if (row != nullptr && persistent(*row))
      static_cast<void>(params.write(row->id, get(set.subspan(at + 4)), true));
  }
}

StoreStatus ParamStore::save(const Params& params) noexcept {
  std::array<std::byte, kSetBytes> set{};
  std::size_t at = 0;
  for (const ParamRow& row : kParamTable) {
    if (!persistent(row)) continue;
    std::uint32_t bits = 0;
    static_cast<void>(params.read(row.id, bits));
    put(std::span(set).subspan(at), row.id);
    put(std::span(set).subspan(at + 4), bits);
    at += kEntryBytes;
  }
  const unsigned slot = sequence_ == 0 ? kFirstSlot : 2 * kFirstSlot + 1 - active_;  // the other one
  const std::uint32_t sequence = next_sequence(sequence_);
  const SlotHeaderBytes header = encode(SlotMagic::kParams, {sequence, kSetBytes, crc32(set)});
  if (!storage_->erase(slot, kSlotHeaderBytes + kSetBytes) || !storage_->write(slot, kSlotHeaderBytes, set) ||
      !storage_->write(slot, 0, header)) {
    return StoreStatus::kStorage;
  }
  active_ = slot;
  sequence_ = sequence;
  crc_ = crc32(set);
  length_ = kSetBytes;
  return StoreStatus::kOk;
}

}  // namespace thimble::firmware
