#include "firmware/scene_store.h"

#include <array>

namespace thimble::firmware {
namespace {

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
    table[i] = value;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = make_crc_table();

// In front of the image, little-endian: magic, layout, sequence, image length, image CRC, CRC of the five
// before it.
constexpr std::uint32_t kMagic = 0x53494854;  // "THIS"
constexpr std::uint32_t kLayout = 1;
constexpr std::size_t kHeaderWords = 6;
static_assert(kHeaderWords * 4 <= SceneStore::kHeaderBytes);
static_assert(SceneStore::kHeaderBytes % 8 == 0, "the image must stay aligned");

struct Header {
  std::uint32_t sequence = 0;
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
};
using HeaderBytes = std::array<std::byte, kHeaderWords * 4>;

HeaderBytes encode(const Header& header) noexcept {
  HeaderBytes bytes{};
  const auto put = [&bytes](std::size_t word, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[word * 4 + i] = static_cast<std::byte>(value >> (8 * i));
  };
  put(0, kMagic);
  put(1, kLayout);
  put(2, header.sequence);
  put(3, header.length);
  put(4, header.crc);
  put(5, crc32(std::span(bytes).first((kHeaderWords - 1) * 4)));
  return bytes;
}

bool decode(std::span<const std::byte> slot, Header& header) noexcept {
  if (slot.size() < SceneStore::kHeaderBytes) return false;
  const auto get = [slot](std::size_t word) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value |= std::to_integer<std::uint32_t>(slot[word * 4 + i]) << (8 * i);
    return value;
  };
  if (get(0) != kMagic || get(1) != kLayout || get(5) != crc32(slot.first((kHeaderWords - 1) * 4)))
    return false;
  header = {get(2), get(3), get(4)};
  return header.sequence != 0 && header.length != 0 &&
         header.length <= slot.size() - SceneStore::kHeaderBytes;
}

// Sequence numbers wrap.
bool newer(std::uint32_t a, std::uint32_t b) noexcept { return static_cast<std::int32_t>(a - b) > 0; }

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t crc) noexcept {
  crc = ~crc;
  for (const std::byte byte : bytes)
    crc = (crc >> 8U) ^ kCrcTable[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xFFU];
  return ~crc;
}

const char* name(StoreStatus status) noexcept {
  switch (status) {
    case StoreStatus::kOk:
      return "ok";
    case StoreStatus::kTooLarge:
      return "too_large";
    case StoreStatus::kNoDownload:
      return "no_download";
    case StoreStatus::kWrongOffset:
      return "wrong_offset";
    case StoreStatus::kIncomplete:
      return "incomplete";
    case StoreStatus::kWrongCrc:
      return "wrong_crc";
    case StoreStatus::kRefused:
      return "refused";
    case StoreStatus::kStorage:
      return "storage";
    case StoreStatus::kBusy:
      return "busy";
  }
  return "unknown";
}

std::size_t SceneStore::capacity() const noexcept {
  const std::size_t bytes = storage_->slot(0).size();
  return bytes > kHeaderBytes ? bytes - kHeaderBytes : 0;
}

StoreStatus SceneStore::open(control::SceneView& view) noexcept {
  std::array<Header, Storage::kSlots> headers;
  std::array<bool, Storage::kSlots> sound{};
  for (unsigned i = 0; i < Storage::kSlots; ++i) sound[i] = decode(storage_->slot(i), headers[i]);
  const unsigned first = sound[1] && (!sound[0] || newer(headers[1].sequence, headers[0].sequence)) ? 1 : 0;
  for (const unsigned i : {first, 1 - first}) {
    if (!sound[i]) continue;
    const auto image = storage_->slot(i).subspan(kHeaderBytes, headers[i].length);
    if (crc32(image) != headers[i].crc) continue;
    image_verdict_ = control::SceneView::check(image, view);
    if (image_verdict_ != control::ImageStatus::kOk) continue;
    active_ = i;
    sequence_ = headers[i].sequence;
    image_crc_ = headers[i].crc;
    image_bytes_ = headers[i].length;
    return StoreStatus::kOk;
  }
  return StoreStatus::kRefused;
}

StoreStatus SceneStore::begin(std::size_t length, std::uint32_t crc) noexcept {
  if (length == 0 || length > capacity()) return StoreStatus::kTooLarge;
  if (downloading_ && length == length_ && crc == expected_crc_) return StoreStatus::kOk;
  abandon();
  if (!storage_->erase(target(), kHeaderBytes + length)) return StoreStatus::kStorage;
  downloading_ = true;
  offset_ = 0;
  length_ = length;
  expected_crc_ = crc;
  return StoreStatus::kOk;
}

StoreStatus SceneStore::write(std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (!downloading_) return StoreStatus::kNoDownload;
  if (offset != offset_ || bytes.size() > length_ - offset_) return StoreStatus::kWrongOffset;
  if (!storage_->write(target(), kHeaderBytes + offset, bytes)) {
    abandon();  // half-written: only an erase makes it writable again
    return StoreStatus::kStorage;
  }
  offset_ += bytes.size();
  return StoreStatus::kOk;
}

StoreStatus SceneStore::verify() noexcept {
  if (!downloading_) return StoreStatus::kNoDownload;
  if (offset_ != length_) return StoreStatus::kIncomplete;
  if (verified_) return StoreStatus::kOk;
  const auto image = storage_->slot(target()).subspan(kHeaderBytes, length_);
  if (crc32(image) != expected_crc_) {
    abandon();
    return StoreStatus::kWrongCrc;
  }
  image_verdict_ = control::SceneView::check(image, checked_);
  if (image_verdict_ != control::ImageStatus::kOk) {
    abandon();
    return StoreStatus::kRefused;
  }
  verified_ = true;
  return StoreStatus::kOk;
}

StoreStatus SceneStore::commit(control::SceneView& view) noexcept {
  if (!downloading_ || !verified_) return StoreStatus::kNoDownload;
  const std::uint32_t sequence = sequence_ + 1 == 0 ? 1 : sequence_ + 1;
  const unsigned slot = target();
  abandon();
  const HeaderBytes header = encode({sequence, static_cast<std::uint32_t>(length_), expected_crc_});
  if (!storage_->write(slot, 0, header)) return StoreStatus::kStorage;
  active_ = slot;
  sequence_ = sequence;
  image_crc_ = expected_crc_;
  image_bytes_ = length_;
  view = checked_;
  return StoreStatus::kOk;
}

}  // namespace thimble::firmware
