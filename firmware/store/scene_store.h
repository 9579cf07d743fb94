// The scene store: two slots, each with a sequence number and CRC-32, so that power may fail at any byte of
// an upload and the last good scene is still there. Called from the background only.
//
//   begin(length, crc) -> write(offset, bytes) ... -> verify(): CRC, then SceneView::check -> commit(view):
//   the header.
//
// A download that the link interrupted goes on: begin() with the same length and CRC keeps what has arrived,
// and offset() says where to continue. The slot of the newest scene is never touched; the scene of the other
// slot is given up at begin().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/scene_view.h"
#include "firmware/store/slot_header.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

enum class StoreStatus : std::uint8_t {
  kOk = 0,
  kTooLarge = 1,     // larger than a slot (or empty)
  kNoDownload = 2,   // write, verify or commit without the step before it
  kWrongOffset = 3,  // not where the download stands, or past its end
  kIncomplete = 4,   // verify before the last byte
  kWrongCrc = 5,     // what stands in the slot is not what was announced
  kRefused = 6,      // SceneView::check said no: image_verdict() says why
  kStorage = 7,      // the hardware refused an erase or a write
  kBusy = 8,         // the tick still reads the slot that would be written
};
[[nodiscard]] const char* name(StoreStatus status) noexcept;  // "wrong_crc"

class SceneStore {
 public:
  static constexpr std::size_t kHeaderBytes = kSlotHeaderBytes;  // in front of the image in each slot

  // pause: called every now and then from O(image) work; may be null.
  explicit SceneStore(Storage& storage, control::Pause pause = nullptr) noexcept
      : storage_(&storage), pause_(pause) {}

  // At start: the newest slot whose header, CRC and scene are sound. kRefused: there is none; `view` is
  // untouched. O(image).
  [[nodiscard]] StoreStatus open(control::SceneView& view) noexcept;

  // After open(): the scene is not used, and stays where it is until an upload takes its place.
  void set_aside() noexcept {
    image_crc_ = 0;
    image_bytes_ = 0;
    newest_ = {};
  }
  [[nodiscard]] bool damaged() const noexcept { return damaged_; }  // what open() saw was

  [[nodiscard]] StoreStatus begin(std::size_t length, std::uint32_t crc) noexcept;
  [[nodiscard]] StoreStatus write(std::size_t offset, std::span<const std::byte> bytes) noexcept;

  // Reads back what was written and checks it. O(image). kWrongCrc and kRefused end the download.
  [[nodiscard]] StoreStatus verify() noexcept;

  // Makes the verified download the newest scene, for this and every later start, and sets `view`.
  // kNoDownload: nothing was verified. kStorage: the old scene stays the newest. O(image) where it is the old one in other materials.
  [[nodiscard]] StoreStatus commit(control::SceneView& view) noexcept;

  void abandon() noexcept {
    downloading_ = verified_ = false;
  }  // forgets the download; the newest scene stays

  [[nodiscard]] bool verified() const noexcept { return verified_; }  // a download waits for commit()
  [[nodiscard]] bool downloading() const noexcept { return downloading_; }
  [[nodiscard]] std::size_t offset() const noexcept {
    return offset_;
  }  // bytes of the download that stand in the slot
  [[nodiscard]] std::size_t length() const noexcept { return length_; }
  [[nodiscard]] std::size_t capacity() const noexcept;                         // the largest image
  [[nodiscard]] std::uint32_t sequence() const noexcept { return sequence_; }  // of the newest scene; 0: none
  [[nodiscard]] std::uint32_t image_crc() const noexcept { return image_crc_; }
  [[nodiscard]] std::size_t image_bytes() const noexcept { return image_bytes_; }
  // How the newest scene may follow the one before it.
  [[nodiscard]] control::Binding binding() const noexcept { return binding_; }
  [[nodiscard]] const control::ImageVerdict& image_verdict() const noexcept {
    return image_verdict_;
  }  // of the last check

 private:
  [[nodiscard]] unsigned target() const noexcept { return sequence_ == 0 ? 0U : 1U - active_; }

  Storage* storage_;
  control::Pause pause_;
  // The newest scene.
  unsigned active_ = 0;
  std::uint32_t sequence_ = 0;
  std::uint32_t image_crc_ = 0;
  std::size_t image_bytes_ = 0;  // 0: there is none, or it is set aside
  bool damaged_ = false;
  control::Binding binding_ = control::Binding::kStart;
  control::SceneView newest_;
  control::ImageVerdict image_verdict_;
  // The download.
  bool downloading_ = false;
  bool verified_ = false;
  control::SceneView checked_;
  std::size_t offset_ = 0;
  std::size_t length_ = 0;
  std::uint32_t expected_crc_ = 0;
};

}  // namespace thimble::firmware
