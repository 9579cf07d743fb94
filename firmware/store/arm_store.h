// The images of the board's own arms (firmware/arm/arm.fbs): two slots for each arm, as for the scenes, so that power may fail at any byte of an
// upload and the last good image is still there. What is stored is the arm after the next start; until then the controller works with the
// one that it has started with. Called from the background only.
//
//   begin(arm, length, crc) -> write(offset, bytes) ... -> verify(): CRC, then read_arm_image() -> commit(): the header.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/limits.h"
#include "firmware/arm/arm_image.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/slot_header.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class ArmStore {
 public:
  static constexpr std::size_t kHeaderBytes = kSlotHeaderBytes;

  // Opens it: O(images).
  explicit ArmStore(Storage& storage, control::Pause pause = nullptr) noexcept;

  // What the controller has started with; where it was damaged, an older one, until begin(). Empty: none is stored, or none that is sound.
  [[nodiscard]] std::span<const std::byte> image(std::size_t arm) const noexcept;
  [[nodiscard]] std::uint32_t image_crc(std::size_t arm) const noexcept { return at_start_[arm].crc; }
  // At start the newest image was damaged: the arm must not be armed with another one before an image has been uploaded. It stays damaged over
  // restarts and over uploads that are broken off at any byte.
  [[nodiscard]] bool damaged(std::size_t arm) const noexcept { return at_start_[arm].damaged; }
  // An image was committed since the start.
  [[nodiscard]] bool waits(std::size_t arm) const noexcept {
    return stored_[arm].sequence != at_start_[arm].sequence;
  }
  [[nodiscard]] std::uint32_t stored_crc(std::size_t arm) const noexcept { return stored_[arm].crc; }

  // kNoDownload: no such arm. Otherwise as in SceneStore.
  [[nodiscard]] StoreStatus begin(std::size_t arm, std::size_t length, std::uint32_t crc) noexcept;
  [[nodiscard]] StoreStatus write(std::size_t offset, std::span<const std::byte> bytes) noexcept;
  [[nodiscard]] StoreStatus verify() noexcept;
  // Makes the verified download the arm of every later start.
  [[nodiscard]] StoreStatus commit() noexcept;
  void abandon() noexcept { downloading_ = verified_ = false; }

  [[nodiscard]] std::size_t arm() const noexcept { return arm_; }  // of the download
  [[nodiscard]] std::size_t offset() const noexcept {
    return offset_;
  }  // bytes of the download that stand in the slot
  [[nodiscard]] ArmStatus verdict() const noexcept { return verdict_; }  // of the last verify()

 private:
  struct Stored {
    std::uint32_t sequence = 0;  // 0: none
    std::uint32_t crc = 0;
    std::uint16_t bytes = 0;
    std::uint8_t slot = 0;
    std::uint8_t damaged_slot = 0;
    bool damaged = false;
  };
  static_assert(kMaxArmImageBytes <= UINT16_MAX);
  static constexpr std::uint8_t first_slot(std::size_t arm) noexcept {
    return static_cast<std::uint8_t>(Storage::kFirstArmSlot + 2 * arm);
  }
  static constexpr std::uint8_t other(std::size_t arm, unsigned slot) noexcept {
    return static_cast<std::uint8_t>(2U * first_slot(arm) + 1U - slot);
  }
  [[nodiscard]] Stored open(std::size_t arm, control::Pause pause) const noexcept;
  [[nodiscard]] std::uint8_t target() const noexcept;
  [[nodiscard]] std::span<const std::byte> image_in(unsigned slot, std::size_t bytes) const noexcept {
    return storage_->slot(slot).subspan(kHeaderBytes, bytes);
  }

  Storage* storage_;
  std::array<Stored, control::kMaxArms> stored_;
  std::array<Stored, control::kMaxArms> at_start_;
  // The download.
  bool downloading_ = false;
  bool verified_ = false;
  ArmStatus verdict_ = ArmStatus::kOk;
  std::size_t arm_ = 0;
  std::size_t offset_ = 0;
  std::size_t length_ = 0;
  std::uint32_t expected_crc_ = 0;
};

}  // namespace thimble::firmware
