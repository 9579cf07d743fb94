// The constants of the tick: the Config, checked once, with the arm models that it names.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/config.h"
#include "kinematics/arm.h"

namespace thimble::firmware {

struct Setup {
  explicit Setup(const Config& config) noexcept;

  float period_s;
  std::uint8_t arm_count;  // 0: the Config cannot work, and the controller stays faulted with bad_config
  bool board_lacks;        // Config::lacks is not empty
  std::array<kinematics::Arm<float>, kMaxArms> arm;
  std::array<bool, kMaxArms> has_index;
  std::array<bool, kMaxArms> has_line_loss;
};

}  // namespace thimble::firmware
