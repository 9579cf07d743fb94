// A serial NOR flash of 64 MiB (N25Q512A, MT25QU512A and alike: 256-byte pages, 64 KiB sectors, 4-byte
// addresses) on the lower bus of the quad SPI controller, one data line, polled. Called from the background.
// The functions wait for the flash (a page: 0.2 ms, a sector: 0.15 s, at most 1 s) and meanwhile call the
// pause function every few microseconds, in which the board runs its ticks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/pauses.h"

namespace thimble::board {

class Nor {
 public:
  static constexpr std::size_t kPageBytes = 256;
  static constexpr std::size_t kSectorBytes = 65536;

  explicit Nor(control::Pause pause) noexcept;

  // True if a chip of 64 MiB answers.
  [[nodiscard]] bool present() const noexcept { return present_; }

  // Each returns false if the controller or the chip did not finish in time. Erasing and writing are verified
  // by reading back; false if the verification fails.
  [[nodiscard]] bool read(std::uint32_t address, std::span<std::byte> bytes) noexcept;
  [[nodiscard]] bool erase_sector(std::uint32_t address) noexcept;  // the sector that contains the address
  [[nodiscard]] bool write(std::uint32_t address, std::span<const std::byte> bytes) noexcept;

 private:
  [[nodiscard]] bool write_page(std::uint32_t address, std::span<const std::byte> bytes) noexcept;
  [[nodiscard]] bool wait_until_done(std::uint32_t limit_us) noexcept;

  control::Pause pause_;
  bool present_ = false;
};

}  // namespace thimble::board
