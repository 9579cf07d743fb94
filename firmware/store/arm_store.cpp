#include "firmware/store/arm_store.h"

#include <algorithm>
#include <array>
#include <type_traits>

namespace thimble::firmware {

static_assert(Storage::kFirstArmSlot + 2 * control::kMaxArms == Storage::kSlots);

namespace {

#ifdef THIMBLE_NO_TEXTS
// The stack of a bare-metal board has no room for the numbers of an arm. It has one controller, and one thread. read_arm_image() begins the
// object's life.
[[gnu::section(".slots")]] alignas(
    kinematics::ArmData) std::array<std::byte, sizeof(kinematics::ArmData)> judged;
static_assert(std::is_trivially_destructible_v<kinematics::ArmData>);
#endif

ArmStatus judge(std::span<const std::byte> image) noexcept {
#ifdef THIMBLE_NO_TEXTS
  auto& arm = *static_cast<kinematics::ArmData*>(static_cast<void*>(judged.data()));
#else
  kinematics::ArmData arm;
#endif
  return read_arm_image(image, arm);
}

bool is_marked(std::span<const std::byte> slot) noexcept {
  std::uint32_t magic = 0;
  for (std::size_t i = 0; i < sizeof magic && i < slot.size(); ++i)
    magic |= std::to_integer<std::uint32_t>(slot[i]) << (8 * i);
  return magic == static_cast<std::uint32_t>(SlotMagic::kArm);
}

}  // namespace

ArmStore::ArmStore(Storage& storage, control::Pause pause) noexcept : storage_(&storage) {
  for (std::size_t arm = 0; arm < stored_.size(); ++arm) stored_[arm] = open(arm, pause);
  at_start_ = stored_;
}

// An older image is kept, but damage of the newest is not passed over: it may be that of another arm.
ArmStore::Stored ArmStore::open(std::size_t arm, control::Pause pause) const noexcept {
  const NewestFirst found = newest_first(*storage_, first_slot(arm), SlotMagic::kArm, pause);
  bool damaged = found.damaged;
  for (const auto& [slot, header] : std::span(found.slot).first(found.count)) {
    if (judge(image_in(slot, header.length)) == ArmStatus::kOk)
      return {.sequence = header.sequence,
              .crc = header.crc,
              .bytes = static_cast<std::uint16_t>(header.length),  // at most kMaxArmImageBytes: it is judged
              .slot = static_cast<std::uint8_t>(slot),
              .damaged_slot = other(arm, slot),
              .damaged = damaged};
    damaged = true;
  }
  const std::uint8_t first = first_slot(arm);
  return {.damaged_slot = is_marked(storage_->slot(first)) ? first : other(arm, first), .damaged = damaged};
}

std::span<const std::byte> ArmStore::image(std::size_t arm) const noexcept {
  const Stored& start = at_start_[arm];
  return start.sequence == 0 ? std::span<const std::byte>() : image_in(start.slot, start.bytes);
}

// What is damaged stays until there is a sound one: if the upload is broken off, the next start must not take the older image or the built-in
// arm for the right one.
std::uint8_t ArmStore::target() const noexcept {
  const Stored& now = stored_[arm_];
  if (now.damaged) return other(arm_, now.damaged_slot);
  return now.sequence == 0 ? first_slot(arm_) : other(arm_, now.slot);
}

StoreStatus ArmStore::begin(std::size_t arm, std::size_t length, std::uint32_t crc) noexcept {
  if (arm >= stored_.size()) return StoreStatus::kNoDownload;
  const std::size_t slot_bytes = storage_->slot(first_slot(arm)).size();
  const std::size_t capacity = slot_bytes > kHeaderBytes ? slot_bytes - kHeaderBytes : 0;
  if (length == 0 || length > std::min(capacity, kMaxArmImageBytes)) return StoreStatus::kTooLarge;
  if (downloading_ && arm == arm_ && length == length_ && crc == expected_crc_) return StoreStatus::kOk;
  abandon();
  arm_ = arm;
  if (!storage_->erase(target(), kHeaderBytes + length)) return StoreStatus::kStorage;
  downloading_ = true;
  offset_ = 0;
  length_ = length;
  expected_crc_ = crc;
  return StoreStatus::kOk;
}

StoreStatus ArmStore::write(std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (!downloading_) return StoreStatus::kNoDownload;
  if (offset != offset_ || bytes.size() > length_ - offset_) return StoreStatus::kWrongOffset;
  if (!storage_->write(target(), kHeaderBytes + offset, bytes)) {
    abandon();  // half-written: only an erase makes it writable again
    return StoreStatus::kStorage;
  }
  offset_ += bytes.size();
  return StoreStatus::kOk;
}

StoreStatus ArmStore::verify() noexcept {
  if (!downloading_) return StoreStatus::kNoDownload;
  if (offset_ != length_) return StoreStatus::kIncomplete;
  if (verified_) return StoreStatus::kOk;
  const auto image = image_in(target(), length_);
  if (crc32(image) != expected_crc_) {
    abandon();
    return StoreStatus::kWrongCrc;
  }
  verdict_ = judge(image);
  verified_ = verdict_ == ArmStatus::kOk;
  if (verified_) return StoreStatus::kOk;
  abandon();
  return StoreStatus::kRefused;
}

StoreStatus ArmStore::commit() noexcept {
  if (!downloading_ || !verified_) return StoreStatus::kNoDownload;
  Stored& now = stored_[arm_];
  const std::uint8_t slot = target();
  const Stored next = {.sequence = next_sequence(now.sequence),
                       .crc = expected_crc_,
                       .bytes = static_cast<std::uint16_t>(length_),
                       .slot = slot};
  abandon();
  if (!storage_->write(slot, 0, encode(SlotMagic::kArm, {next.sequence, next.bytes, next.crc})))
    return StoreStatus::kStorage;
  if (now.damaged && !storage_->erase(now.damaged_slot, kHeaderBytes)) return StoreStatus::kStorage;
  now = next;
  return StoreStatus::kOk;
}

}  // namespace thimble::firmware
