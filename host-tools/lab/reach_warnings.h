// What of a scene an arm cannot touch.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host-tools/lab/arm_choice.h"

namespace thimble::host {

// A warning for each object whose box (object_regions.h) the tip does not come to within the limits of the axes, with the distance. The tip is at the
// origin with all axes at home, and the base stands as without a mounting. A box in which a tip is need not be an object that it touches: there
// is no warning then.
[[nodiscard]] std::vector<std::string> reach_warnings(std::span<const std::byte> image, const ArmChoice& arm,
                                                      double tip_radius_m);

}  // namespace thimble::host
