// The arm that an option names: a simulated one that is built in, one that comes with Thimble, an arm file, or an arm image.
#pragma once

#include <optional>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/compiler/stable_stiffness.h"

namespace thimble::host {

struct ArmChoice {
  std::string name;  // of the arm: "falcon" for falcon.arm.json
  kinematics::ArmData data;
  ArmWalls walls;  // of its file, or of docs/stability.md; an image has none
};

// Throws Error: kUsage (unknown-arm) if `name` is no arm and no file; kBadInput if the file is no arm that can work, or no sound image.
[[nodiscard]] ArmChoice chosen_arm(const std::string& name);

// The same for a simulation. Nothing: `name` is a plant variant (board/sim/plant.h).
[[nodiscard]] std::optional<kinematics::ArmData> other_arm(const std::string& name);

// The walls of an arm file that has some; otherwise those of docs/stability.md for an arm of this name, which may be none.
[[nodiscard]] ArmWalls walls_of(const ArmFile& arm, const std::string& file);

}  // namespace thimble::host
