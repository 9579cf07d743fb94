#include "firmware/store/journal.h"

#include <algorithm>
#include <cmath>

#include "firmware/store/slot_header.h"

namespace thimble::firmware {
namespace {

// Little-endian words: sequence, time, flags and crashes, three times scene and parameters, heat (two bytes each), CRC of all before it.
constexpr std::size_t kHeatAt = 36, kCrcAt = 60;
static_assert(kHeatAt + 2 * 2 * kJoints * kMaxArms == kCrcAt && kCrcAt + 4 == Journal::kRecordBytes);
constexpr std::uint32_t kMotorsOn = 1, kOnTrial = 2;
constexpr float kPerKelvin = 64;  // of a stored temperature: up to 1023 K
constexpr float kMostHeat = 65535;

using RecordBytes = std::array<std::byte, Journal::kRecordBytes>;

void put_word(RecordBytes& bytes, std::size_t at, std::uint32_t value, std::size_t size = 4) noexcept {
  for (std::size_t i = 0; i < size; ++i) bytes[at + i] = static_cast<std::byte>(value >> (8 * i));
}
std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at, std::size_t size = 4) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

// Never less than it is.
std::uint32_t stored(float kelvin) noexcept {
  return static_cast<std::uint32_t>(std::clamp(std::ceil(kelvin * kPerKelvin), 0.0F, kMostHeat));
}
float kelvin_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  return static_cast<float>(word_at(bytes, at, 2)) / kPerKelvin;
}

void put_in_use(RecordBytes& bytes, std::size_t at, const JournalRecord::InUse& used) noexcept {
  put_word(bytes, at, used.scene);
  put_word(bytes, at + 4, used.params);
}
JournalRecord::InUse in_use_at(std::span<const std::byte> bytes, std::size_t at) noexcept {
  return {word_at(bytes, at), word_at(bytes, at + 4)};
}

RecordBytes encode(const JournalRecord& record, std::uint32_t sequence) noexcept {
  RecordBytes bytes{};
  put_word(bytes, 0, sequence);
  put_word(bytes, 4, record.utc_s);
  put_word(bytes, 8,
           (record.motors_on ? kMotorsOn : 0) | (record.on_trial ? kOnTrial : 0) |
               static_cast<std::uint32_t>(record.crashes) << 8U);
  put_in_use(bytes, 12, record.used);
  put_in_use(bytes, 20, record.set_aside);
  put_in_use(bytes, 28, record.proven);
  std::size_t at = kHeatAt;
  for (const auto& arm : record.heat) {
    for (const Heat& motor : arm) {
      put_word(bytes, at, stored(motor.winding_K), 2);
      put_word(bytes, at + 2, stored(motor.housing_K), 2);
      at += 4;
    }
  }
  put_word(bytes, kCrcAt, crc32(std::span(bytes).first(kCrcAt)));
  return bytes;
}

// 0: it is not valid.
std::uint32_t sequence_of(std::span<const std::byte> bytes) noexcept {
  return word_at(bytes, kCrcAt) == crc32(bytes.first(kCrcAt)) ? word_at(bytes, 0) : 0;
}

JournalRecord decode(std::span<const std::byte> bytes) noexcept {
  JournalRecord record;
  record.utc_s = word_at(bytes, 4);
  const std::uint32_t flags = word_at(bytes, 8);
  record.motors_on = (flags & kMotorsOn) != 0;
  record.on_trial = (flags & kOnTrial) != 0;
  record.crashes = static_cast<std::uint8_t>(flags >> 8U);
  record.used = in_use_at(bytes, 12);
  record.set_aside = in_use_at(bytes, 20);
  record.proven = in_use_at(bytes, 28);
  std::size_t at = kHeatAt;
  for (auto& arm : record.heat) {
    for (Heat& motor : arm) {
      motor = {kelvin_at(bytes, at), kelvin_at(bytes, at + 2)};
      at += 4;
    }
  }
  return record;
}

bool erased(std::span<const std::byte> bytes) noexcept {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte byte) { return byte == std::byte{0xFF}; });
}

}  // namespace

std::optional<JournalRecord> Journal::open() noexcept {
  std::optional<JournalRecord> newest;
  for (unsigned slot = Storage::kFirstJournalSlot; slot < Storage::kSlots; ++slot) {
    for (std::size_t i = 0; i < places(slot); ++i) {
      const std::uint32_t sequence = sequence_of(place(slot, i));
      // Sequence numbers wrap.
      if (sequence == 0 || (newest && static_cast<std::int32_t>(sequence - sequence_) <= 0)) continue;
      newest = decode(place(slot, i));
      sequence_ = sequence;
      active_ = slot;
    }
  }
  active_has_newest_ = true;
  next_ = places(active_);
  while (next_ != 0 && erased(place(active_, next_ - 1))) --next_;
  other_erased_ = erased(storage_->slot(other()));
  return newest;
}

bool Journal::erase_other() noexcept {
  other_erased_ = storage_->erase(other(), storage_->slot(other()).size());
  return other_erased_;
}

bool Journal::append(const JournalRecord& record) noexcept {
  if (next_ >= places(active_)) {
    // Where no record of the active slot could be written, the newest one is still in the other.
    if (!active_has_newest_) {
      active_ = other();
      other_erased_ = false;
    }
    if (!other_erased_ && !erase_other()) return false;
    active_ = other();
    next_ = 0;
    other_erased_ = active_has_newest_ = false;
  }
  const std::uint32_t sequence = next_sequence(sequence_);
  // A place that was written by half is used up.
  if (!storage_->write(active_, kRecordBytes * next_++, encode(record, sequence))) return false;
  sequence_ = sequence;
  active_has_newest_ = true;
  return true;
}

void Journal::prepare() noexcept {
  if (active_has_newest_ && !other_erased_ && next_ > places(active_) / 2) static_cast<void>(erase_other());
}

}  // namespace thimble::firmware
