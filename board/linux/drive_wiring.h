// Where a joint's drive on CAN is and what it must be, as the board's configuration says it. Units: SI, at the drive's shaft, which is the
// motor of the arm model.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "board/linux/drives/drive_config.h"

namespace thimble::board {

inline constexpr std::size_t kArmJoints =
    7;  // at most, that a configuration wires of an arm; kinematics::kMaxJoints

struct DriveWiring {
  struct Item {  // of the drive's own configuration, read back at start
    std::string name;
    std::uint16_t number = 0;
    bool integer = false;
    double value = 0;
  };

  std::string interface;       // "can0"
  drives::DriveConfig config;  // its items are empty: `items` has them
  std::vector<Item> items;
  float direction = 1;  // of the drive's position and torque over the model's motor: 1 or -1
};
using DriveWirings = std::array<std::optional<DriveWiring>, kArmJoints>;

// The kinds as the configuration names them.
[[nodiscard]] const char* name_of(drives::Kind kind) noexcept;

}  // namespace thimble::board
