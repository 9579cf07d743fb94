// What an arm's motor currents and its amplifiers' enable leave by. Implementations: spi_dac.h, gpio.h, and tests.
#pragma once

#include <array>

#include "board/linux/drive_wiring.h"

namespace thimble::board {

class CurrentOutput {
 public:
  virtual ~CurrentOutput() = default;
  // Of each joint; those with a drive are 0. False: it failed, and the outputs are as they were. At most a bus transfer.
  [[nodiscard]] virtual bool write(const std::array<float, kArmJoints>& current_A) noexcept = 0;
  [[nodiscard]] bool zero() noexcept { return write({}); }
};

class SwitchOutput {
 public:
  virtual ~SwitchOutput() = default;
  [[nodiscard]] virtual bool set(bool active) noexcept = 0;  // false: the line is gone
};

}  // namespace thimble::board
