// Motor currents of one arm by an AD5754R on spidev (encoding: board/common/ad5754.h). Output A
// drives the first joint, and so on. One system call per tick.
//
// The constructor throws std::system_error with the device. Nothing else throws.
#pragma once

#include <linux/spi/spidev.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "board/common/ad5754.h"
#include "board/linux/open_file.h"
#include "board/linux/outputs.h"

namespace thimble::board {

class SpiDac final : public CurrentOutput {
 public:
  // The current is zero before, during and after construction.
  SpiDac(const std::string& device, std::uint32_t speed_Hz,
         const std::array<std::optional<Ad5754::Channel>, Ad5754::kOutputs>& channels);
  SpiDac(SpiDac&&) = delete;

  // False: the transfer failed; the converter keeps its voltages.
  [[nodiscard]] bool write(const std::array<float, kArmJoints>& current_A) noexcept override;

 private:
  struct Output {
    Ad5754::Channel channel;
    std::uint8_t joint = 0;  // and its number at the converter
  };
  [[nodiscard]] bool command(const Ad5754::Frame& frame) noexcept;

  Descriptor device_;
  std::array<Output, Ad5754::kOutputs> outputs_{};
  std::size_t count_ = 0;                                     // of outputs in use
  std::array<Ad5754::Frame, Ad5754::kOutputs + 1> frames_{};  // a voltage for each, then the load
  std::array<spi_ioc_transfer, Ad5754::kOutputs + 1> transfers_{};
};

}  // namespace thimble::board
