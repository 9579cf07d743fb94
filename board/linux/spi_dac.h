// The motor currents of one arm on an AD5754R behind spidev (board/common/ad5754.h has its words): outputs A, B and C are
// the motors 1, 2 and 3. One system call a tick.
//
// The constructor throws std::system_error with the device. Nothing else throws.
#pragma once

#include <linux/spi/spidev.h>

#include <array>
#include <cstdint>
#include <string>

#include "board/common/ad5754.h"
#include "board/linux/open_file.h"

namespace thimble::board {

class SpiDac {
 public:
  // No current flows before, in and after it.
  SpiDac(const std::string& device, std::uint32_t speed_Hz, const std::array<Ad5754::Channel, 3>& channels);
  SpiDac(SpiDac&&) = delete;

  // False: the converter was not reached, and keeps what it had.
  [[nodiscard]] bool write(const std::array<float, 3>& current_A) noexcept;
  [[nodiscard]] bool zero() noexcept { return write({}); }

 private:
  static constexpr std::size_t kFrames = 4;  // three voltages and the load
  [[nodiscard]] bool command(const Ad5754::Frame& frame) noexcept;

  Descriptor device_;
  std::array<Ad5754::Channel, 3> channels_;
  std::array<Ad5754::Frame, kFrames> frames_{};
  std::array<spi_ioc_transfer, kFrames> transfers_{};
};

}  // namespace thimble::board
