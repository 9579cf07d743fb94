// The numbers of an arm file as a board has them: what a board reads from arm_image() (arm_writer.h), without the detour.
#pragma once

#include "host-tools/arms/arm_file.h"
#include "kinematics/arm_data.h"

namespace thimble::host {

[[nodiscard]] kinematics::ArmData arm_data(const ArmFile& arm);

}  // namespace thimble::host
