#include "firmware/store/scene_store.h"

#include "control/scene/same_shapes.h"

namespace thimble::firmware {

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
  const NewestFirst found = newest_first(*storage_, 0, SlotMagic::kScene, pause_);
  damaged_ = found.damaged;
  for (const auto& [slot, header] : std::span(found.slot).first(found.count)) {
    image_verdict_ =
        control::SceneView::check(storage_->slot(slot).subspan(kHeaderBytes, header.length), view, pause_);
    if (image_verdict_ != control::ImageStatus::kOk) continue;
    active_ = slot;
    sequence_ = header.sequence;
    image_crc_ = header.crc;
    image_bytes_ = header.length;
    newest_ = view;
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
  if (crc32(image, pause_) != expected_crc_) {
    abandon();
    return StoreStatus::kWrongCrc;
  }
  image_verdict_ = control::SceneView::check(image, checked_, pause_);
  if (image_verdict_ != control::ImageStatus::kOk) {
    abandon();
    return StoreStatus::kRefused;
  }
  verified_ = true;
  return StoreStatus::kOk;
}

StoreStatus SceneStore::commit(control::SceneView& view) noexcept {
  if (!downloading_ || !verified_) return StoreStatus::kNoDownload;
  const std::uint32_t sequence = next_sequence(sequence_);
  const unsigned slot = target();
  abandon();
  const SlotHeaderBytes header =
      encode(SlotMagic::kScene, {sequence, static_cast<std::uint32_t>(length_), expected_crc_});
  if (!storage_->write(slot, 0, header)) return StoreStatus::kStorage;
  binding_ = image_bytes_ == 0
                 ? control::Binding::kStart
                 : control::binding_of(storage_->slot(active_).subspan(kHeaderBytes, image_bytes_), newest_,
                                       storage_->slot(slot).subspan(kHeaderBytes, length_), checked_, pause_);
  active_ = slot;
  sequence_ = sequence;
  image_crc_ = expected_crc_;
  image_bytes_ = length_;
  newest_ = checked_;
  view = checked_;
  return StoreStatus::kOk;
}

}  // namespace thimble::firmware
