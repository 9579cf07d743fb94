// An arm image in a file, as `thimble model compile` writes it (docs/cli.md).
#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "kinematics/arm_data.h"

namespace thimble::board {

// what(): name ("bad-arm-image"), cause and remedy.
class ArmImageError : public std::runtime_error {
 public:
  ArmImageError(const std::string& why, const std::string& what_to_do)
      : std::runtime_error("bad-arm-image: " + why + "\n  remedy: " + what_to_do),
        cause(why),
        remedy(what_to_do) {}
  std::string cause, remedy;
};

// Nothing: `name` does not end with .tarm. Throws ArmImageError for a file that is no sound arm image, and
// FileError for one that cannot be read.
[[nodiscard]] std::optional<kinematics::ArmData> arm_of_image(const std::string& name);

}  // namespace thimble::board
