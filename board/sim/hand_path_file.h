// File format of a hand's path: CSV with the header `time_s,x_m,y_m,z_m` and optionally `arm` (0 or 1), one
// point per row. Columns may have any order. Used by `thimble simulate --path` and `thimble-sim --hand`.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "board/sim/hand_path.h"

namespace thimble::board {

// what(): file, line and cause.
class HandPathError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Requires at least one row, times within 1e6 s and places within 1000 m of 0, and times that rise by 1 ns and more for each arm.
// Throws HandPathError.
[[nodiscard]] std::vector<PathPoint> read_hand_path(const std::filesystem::path& file);

}  // namespace thimble::board
