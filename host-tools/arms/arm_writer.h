// The image of an arm file: what boards and the simulated arm read (firmware/arm/arm.fbs).
#pragma once

#include <cstddef>
#include <vector>

#include "host-tools/arms/arm_file.h"

namespace thimble::host {

// The same file gives the same bytes.
[[nodiscard]] std::vector<std::byte> arm_image(const ArmFile& arm);

}  // namespace thimble::host
