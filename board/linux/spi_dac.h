// Motor currents of one arm by an AD5754R on spidev (encoding: board/common/ad5754.h). Outputs A, B and C
// drive the motors 1, 2 and 3. One system call per tick.
//
// The constructor throws std::system_error with the device. Nothing else throws.
#pragma once

#include <linux/spi/spidev.h>

#include <array>
#include <cstdint>
#include <string>

#include "board/common/ad5754.h"
#include "board/linux/open_file.h"
#include "board/linux/outputs.h"

namespace thimble::board {

class SpiDac final : public CurrentOutput {
 public:
  // The current is zero before, during and after construction.
  SpiDac(const std::string& device, std::uint32_t speed_Hz,
         const std::array<Ad5754::Channel, kArmJoints>& channels);
  SpiDac(SpiDac&&) = delete;

  // False: the transfer failed; the converter keeps its voltages.
  [[nodiscard]] bool write(const std::array<float, kArmJoints>& current_A) noexcept override;

 private:
  static constexpr std::size_t kFrames = kArmJoints + 1;  // the voltages and the load
  [[nodiscard]] bool command(const Ad5754::Frame& frame) noexcept;

  Descriptor device_;
  std::array<Ad5754::Channel, kArmJoints> channels_;
  std::array<Ad5754::Frame, kFrames> frames_{};
  std::array<spi_ioc_transfer, kFrames> transfers_{};
};

}  // namespace thimble::board
