// The arm that --arm names: a simulated one that is built in, one that comes with Thimble, or an arm file.
#pragma once

#include <optional>
#include <string>

#include "host-tools/arms/arm_data.h"

namespace thimble::host {

// Nothing: `name` is a plant variant (board/sim/plant.h). Throws Error: kUsage (unknown-arm) if it is no arm and no file, kBadInput if the file
// is no arm that can work.
[[nodiscard]] std::optional<kinematics::ArmData> other_arm(const std::string& name);

}  // namespace thimble::host
