// A serial NOR flash of 64 MiB (N25Q512A, MT25QU512A and alike: 256-byte pages, 64 KiB sectors, 4-byte addresses) on the lower bus of
// the quad SPI controller, one data line, polled. Called from the background. What takes long (a page: 0.2 ms, a sector: 0.15 s, 1 s at
// worst) is waited for; meanwhile the pause function is called every few microseconds, in which the board runs its ticks.
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

  // A chip answers, and is one of 64 MiB.
  [[nodiscard]] bool present() const noexcept { return present_; }

  // Each is false where the controller or the chip did not finish in time. What was erased or written is read back; false, too, where
  // it is not there.
  [[nodiscard]] bool read(std::uint32_t address, std::span<std::byte> bytes) noexcept;
  [[nodiscard]] bool erase_sector(std::uint32_t address) noexcept;  // the one that holds the address
  [[nodiscard]] bool write(std::uint32_t address, std::span<const std::byte> bytes) noexcept;

 private:
  [[nodiscard]] bool write_page(std::uint32_t address, std::span<const std::byte> bytes) noexcept;
  [[nodiscard]] bool wait_until_done(std::uint32_t limit_us) noexcept;

  control::Pause pause_;
  bool present_ = false;
};

}  // namespace thimble::board
