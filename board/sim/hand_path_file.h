// A hand's path as people write it: CSV with the header `time_s,x_m,y_m,z_m`, and optionally `arm` (0 or 1),
// one point a row. Columns may stand in any order. Used by `thimble simulate --path` and `thimble-sim
// --hand`.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "board/sim/hand_path.h"

namespace thimble::board {

// what(): file, line and what is wrong.
class HandPathError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// At least one row; every number finite; the times of each arm strictly rising. Throws HandPathError.
[[nodiscard]] std::vector<PathPoint> read_hand_path(const std::filesystem::path& file);

}  // namespace thimble::board
