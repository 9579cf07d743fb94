// An arm image in a file, as `thimble model compile` writes it (docs/cli.md).
#pragma once

#include <optional>
#include <string>

#include "kinematics/arm_data.h"

namespace thimble::board {

// Nothing: `name` does not end with .tarm. Throws std::runtime_error with name, cause and remedy for a file that is no sound arm image, and
// FileError for one that cannot be read.
[[nodiscard]] std::optional<kinematics::ArmData> arm_of_image(const std::string& name);

}  // namespace thimble::board
