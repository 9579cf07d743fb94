// The slots in the EEPROMs, with a copy in RAM that the tick reads. The memory of all chips that answer at
// start is divided between the two scenes: one chip holds scenes of 25 kB, eight hold scenes of 239 kB
// (docs/board-mps2-an500.md lists the demonstrations). With one chip there is no room for arm images.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "board/mps2-an500/eeprom.h"
#include "firmware/store/storage.h"

namespace thimble::board {

class EepromStorage final : public firmware::Storage {
 public:
  // Reads the content of the slots: about a second for a scene of 64 kB.
  EepromStorage() noexcept;

  [[nodiscard]] bool present() const noexcept { return share_bytes_ != 0; }

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  [[nodiscard]] bool overwrites() const noexcept override { return true; }
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

 private:
  [[nodiscard]] std::span<std::byte> copy(unsigned index) const noexcept;
  [[nodiscard]] std::size_t address(unsigned index) const noexcept;
  [[nodiscard]] std::size_t bytes(unsigned index) const noexcept;

  std::size_t share_bytes_ =
      0;  // a scene, and behind it a slot of each arm, of the key, of the audit record and of the journal
  bool has_arms_ = false;
};

}  // namespace thimble::board
