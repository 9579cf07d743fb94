#include "firmware/store/record_slots.h"

#include <algorithm>

#include "firmware/store/slot_header.h"

namespace thimble::firmware {
namespace {

// 0: it is not valid.
std::uint32_t sequence_of(std::span<const std::byte> record) noexcept {
  return word_at(record, kRecordCrcAt) == crc32(record.first(kRecordCrcAt)) ? word_at(record, 0) : 0;
}

// Sequence numbers wrap.
bool newer(std::uint32_t sequence, std::uint32_t than) noexcept {
  return static_cast<std::int32_t>(sequence - than) > 0;
}

bool erased(std::span<const std::byte> bytes) noexcept {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte byte) { return byte == std::byte{0xFF}; });
}

}  // namespace

void put_word(RecordBytes& record, std::size_t at, std::uint32_t value, std::size_t size) noexcept {
  for (std::size_t i = 0; i < size; ++i) record[at + i] = static_cast<std::byte>(value >> (8 * i));
}

std::uint32_t word_at(std::span<const std::byte> record, std::size_t at, std::size_t size) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint32_t>(record[at + i]) << (8 * i);
  return value;
}

template <class Visit>
void RecordSlots::visit_places(Visit&& visit) const noexcept {
  for (unsigned slot = first_; slot < first_ + 2; ++slot)
    for (std::size_t i = 0; i < places(slot); ++i) visit(slot, i, place(slot, i));
}

std::span<const std::byte> RecordSlots::open() noexcept {
  std::span<const std::byte> newest;
  std::size_t at = 0;
  sequence_ = 0;
  active_ = first_;
  visit_places([&](unsigned slot, std::size_t index, std::span<const std::byte> record) {
    const std::uint32_t sequence = sequence_of(record);
    if (sequence == 0 || (!newest.empty() && !newer(sequence, sequence_))) return;
    newest = record;
    sequence_ = sequence;
    active_ = slot;
    at = index + 1;
  });
  active_has_newest_ = true;
  next_ = storage_.overwrites() ? at : places(active_);
  while (next_ > at && erased(place(active_, next_ - 1))) --next_;
  other_erased_ = erased(storage_.slot(other()));
  return newest;
}

bool RecordSlots::erase_other() noexcept {
  other_erased_ = storage_.erase(other(), storage_.slot(other()).size());
  return other_erased_;
}

bool RecordSlots::append(RecordBytes& record) noexcept {
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
  put_word(record, 0, sequence);
  put_word(record, kRecordCrcAt, crc32(std::span(record).first(kRecordCrcAt)));
  // A place that was written by half is used up. A worn flash may say that it has written.
  const std::size_t at = next_++;
  if (!storage_.write(active_, kRecordBytes * at, record)) return false;
  if (!std::ranges::equal(place(active_, at), std::as_bytes(std::span(record)))) return false;
  sequence_ = sequence;
  active_has_newest_ = true;
  return true;
}

void RecordSlots::prepare(std::size_t places_free) noexcept {
  if (active_has_newest_ && !other_erased_ && next_ + places_free >= places(active_))
    static_cast<void>(erase_other());
}

std::uint32_t RecordSlots::at_or_after(std::uint32_t sequence) const noexcept {
  constexpr std::uint32_t kBefore = 0x8000'0000;  // so far ahead means: behind
  if (sequence == 0) sequence = sequence_ - kBefore + 1;
  std::uint32_t least = kBefore;
  visit_places([&](unsigned, std::size_t, std::span<const std::byte> record) {
    const std::uint32_t distance = word_at(record, 0) - sequence;
    if (distance < least && sequence_of(record) != 0) least = distance;
  });
  return least < kBefore ? sequence + least : 0;
}

void RecordSlots::find(std::uint32_t from, std::span<std::span<const std::byte>> found) const noexcept {
  visit_places([&](unsigned, std::size_t, std::span<const std::byte> record) {
    const std::uint32_t index = word_at(record, 0) - from;
    if (index < found.size() && sequence_of(record) != 0) found[index] = record;
  });
}

}  // namespace thimble::firmware
