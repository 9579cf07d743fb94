// The slots in the flash, with a copy in DDR that the tick reads. Called from the background.
//
// A slot's first sector is erased at once, and the old content with it; each further sector when the first byte of it is written. So
// the seconds that erasing takes are spread over an upload, and no request waits longer than one sector takes.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "board/zynqmp/nor.h"
#include "firmware/store/storage.h"

namespace thimble::board {

class NorStorage final : public firmware::Storage {
 public:
  // Reads what the slots hold: a quarter of a second a MiB.
  explicit NorStorage(Nor& nor) noexcept;

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

 private:
  [[nodiscard]] std::span<std::byte> copy(unsigned index) const noexcept;

  Nor& nor_;
  std::array<std::size_t, kSlots> erased_{};  // bytes from the slot's beginning
};

}  // namespace thimble::board
