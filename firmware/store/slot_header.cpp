#include "firmware/store/slot_header.h"

#include <algorithm>

namespace thimble::firmware {
namespace {

// Little-endian: magic, layout, sequence, length, CRC of the contents, CRC of the five before it.
constexpr std::uint32_t kLayout = 1;
constexpr std::size_t kHeaderWords = 6;

std::uint32_t word_of(std::span<const std::byte> slot, std::size_t word) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(slot[word * 4 + i]) << (8 * i);
  return value;
}

bool has(std::span<const std::byte> slot, SlotMagic magic) noexcept {
  return slot.size() >= kSlotHeaderBytes && word_of(slot, 0) == static_cast<std::uint32_t>(magic);
}

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, control::Pause pause) noexcept {
  constexpr std::size_t kAtOnce = 1024;
  std::uint32_t crc = 0;
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), kAtOnce);
    crc = crc32(bytes.first(now), crc);
    bytes = bytes.subspan(now);
    if (pause != nullptr) pause();
  }
  return crc;
}

SlotHeaderBytes encode(SlotMagic magic, const SlotHeader& header) noexcept {
  SlotHeaderBytes bytes{};
  const auto put = [&bytes](std::size_t word, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[word * 4 + i] = static_cast<std::byte>(value >> (8 * i));
  };
  put(0, static_cast<std::uint32_t>(magic));
  put(1, kLayout);
  put(2, header.sequence);
  put(3, header.length);
  put(4, header.crc);
  put(5, crc32(std::span(bytes).first((kHeaderWords - 1) * 4)));
  return bytes;
}

bool decode(std::span<const std::byte> slot, SlotMagic magic, SlotHeader& header) noexcept {
  if (!has(slot, magic) || word_of(slot, 1) != kLayout ||
      word_of(slot, 5) != crc32(slot.first((kHeaderWords - 1) * 4)))
    return false;
  header = {word_of(slot, 2), word_of(slot, 3), word_of(slot, 4)};
  return header.sequence != 0 && header.length != 0 && header.length <= slot.size() - kSlotHeaderBytes;
}

NewestFirst newest_first(const Storage& storage, unsigned first_slot, SlotMagic magic,
                         control::Pause pause) noexcept {
  NewestFirst found;
  std::array<SlotHeader, 2> headers;
  std::array<bool, 2> sound{};
  for (unsigned i = 0; i < 2; ++i) {
    const std::span<const std::byte> slot = storage.slot(first_slot + i);
    sound[i] = decode(slot, magic, headers[i]);
    if (!sound[i] && has(slot, magic)) found.damaged = true;
  }
  // Sequence numbers wrap.
  const bool second_is_newer = static_cast<std::int32_t>(headers[1].sequence - headers[0].sequence) > 0;
  const unsigned newest = sound[1] && (!sound[0] || second_is_newer) ? 1 : 0;
  for (const unsigned i : {newest, 1 - newest}) {
    if (!sound[i]) continue;
    if (crc32(storage.slot(first_slot + i).subspan(kSlotHeaderBytes, headers[i].length), pause) !=
        headers[i].crc) {
      found.damaged = found.damaged || i == newest;
      continue;
    }
    found.slot[found.count++] = {first_slot + i, headers[i]};
  }
  return found;
}

}  // namespace thimble::firmware
