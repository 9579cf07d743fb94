// The slots in the flash, with a copy in DDR that the tick reads. Called from the background.
//
// erase() erases the first sector of a slot at once, which invalidates the old content, and each further
// sector when its first byte is written. So the erase time is distributed over an upload, and no request
// waits for more than one sector.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "board/zynqmp/nor.h"
#include "firmware/store/storage.h"

namespace thimble::board {

class NorStorage final : public firmware::Storage {
 public:
  // Reads the content of the slots: a quarter of a second per MiB.
  explicit NorStorage(Nor& nor) noexcept;

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

 private:
  [[nodiscard]] std::span<std::byte> copy(unsigned index) const noexcept;

  Nor& nor_;
  std::array<std::size_t, kSlots> erased_{};  // bytes from the start of the slot
};

}  // namespace thimble::board
