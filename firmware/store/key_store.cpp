#include "firmware/store/key_store.h"

#include <algorithm>

#include "firmware/store/slot_header.h"

namespace thimble::firmware {

using link::KeyState;

static_assert(kSlotHeaderBytes + link::kKeyBytes <= Storage::kKeySlotBytes);

namespace {

constexpr std::byte kRemoved{0};  // the contents, instead of a key

// Erased, or a file that was just made.
bool blank(std::span<const std::byte> slot) noexcept {
  const auto is = [](std::byte value) { return [value](std::byte b) { return b == value; }; };
  const std::span<const std::byte> header = slot.first(std::min(slot.size(), kSlotHeaderBytes));
  return std::ranges::all_of(header, is(std::byte{0xFF})) || std::ranges::all_of(header, is(std::byte{0}));
}

constexpr unsigned other(unsigned slot) noexcept { return 2 * Storage::kFirstKeySlot + 1 - slot; }

}  // namespace

void KeyStore::open() noexcept {
  const NewestFirst found = newest_first(*storage_, Storage::kFirstKeySlot, SlotMagic::kKey);
  if (found.count == 0) {
    const bool new_board = blank(storage_->slot(active_)) && blank(storage_->slot(other(active_)));
    state_ = new_board ? KeyState::kNone : KeyState::kDamaged;
    return;
  }
  const auto& [slot, header] = found.slot[0];
  active_ = slot;
  sequence_ = header.sequence;
  const std::span<const std::byte> contents = storage_->slot(slot).subspan(kSlotHeaderBytes, header.length);
  if (contents.size() == key_.size()) {
    std::ranges::transform(contents, key_.begin(),
                           [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
    state_ = KeyState::kSet;
  } else {
    state_ = contents.size() == 1 && contents[0] == kRemoved ? KeyState::kNone : KeyState::kDamaged;
  }
  erase_older();
}

// What is older must not count where the newest is damaged one day. If it fails, the next start tries again.
void KeyStore::erase_older() noexcept {
  if (!blank(storage_->slot(other(active_))))
    static_cast<void>(storage_->erase(other(active_), kSlotHeaderBytes + link::kKeyBytes));
}

StoreStatus KeyStore::write(std::span<const std::byte> contents) noexcept {
  const unsigned slot = sequence_ == 0 ? active_ : other(active_);
  const std::uint32_t sequence = next_sequence(sequence_);
  const SlotHeaderBytes header =
      encode(SlotMagic::kKey, {sequence, static_cast<std::uint32_t>(contents.size()), crc32(contents)});
  if (!storage_->erase(slot, kSlotHeaderBytes + link::kKeyBytes) ||
      !storage_->write(slot, kSlotHeaderBytes, contents) || !storage_->write(slot, 0, header))
    return StoreStatus::kStorage;
  active_ = slot;
  sequence_ = sequence;
  erase_older();
  return StoreStatus::kOk;
}

StoreStatus KeyStore::set(const link::Key& key) noexcept {
  const StoreStatus status = write(std::as_bytes(std::span(key)));
  if (status != StoreStatus::kOk) return status;
  key_ = key;
  state_ = KeyState::kSet;
  return status;
}

StoreStatus KeyStore::remove() noexcept {
  const StoreStatus status = write(std::span(&kRemoved, 1));
  if (status != StoreStatus::kOk) return status;
  key_ = {};
  state_ = KeyState::kNone;
  return status;
}

}  // namespace thimble::firmware
