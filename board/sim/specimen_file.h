// File format of a specimen: JSON with the members of SpecimenMap by name, origin_m, u and v as arrays of
// three, and "thimble_specimen": 1. u and v may have any length; height_m, damping_N_s_m, the frictions and layers
// (objects with depth_m and stiffness_ratio) are optional.
// Used by `thimble-sim --specimen` and `thimble scan --simulate`.
#pragma once

#include <filesystem>
#include <stdexcept>

#include "board/sim/specimen.h"

namespace thimble::board {

// what(): file and cause.
class SpecimenError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[nodiscard]] Specimen read_specimen(const std::filesystem::path& file);

}  // namespace thimble::board
