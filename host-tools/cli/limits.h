// The limits of a scene that `thimble info` prints: every constant of control/scene/limits.h, which
// CMakeLists.txt reads into a table while configuring.
#pragma once

#include <string>
#include <vector>

#include "host-tools/cli/output.h"

namespace thimble::host {

struct LimitRow {
  std::string key;  // kMaxStiffness_N_m is "max_stiffness_N_m"
  Json value;
  std::string of;  // the constant's comment, if any
};
[[nodiscard]] std::vector<LimitRow> scene_limits();

}  // namespace thimble::host
