// A line through a volume, cut into layers of tissue.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "host-tools/lab/nifti.h"
#include "host-tools/lab/tissue_table.h"

namespace thimble::host {

// What a straight line meets: equal steps of at most a quarter of a voxel, each with the value of the voxel at its middle.
struct LineProfile {
  double step_mm = 0;
  std::vector<double> values;
};

// from_mm, to_mm: in the volume's world. Throws Error (kBadInput): outside-volume, bad-line, bad-volume (a voxel that is no number).
[[nodiscard]] LineProfile profile_along(const Volume& volume, const Eigen::Vector3d& from_mm,
                                        const Eigen::Vector3d& to_mm, const std::string& name);

struct TissueLayer {
  std::size_t kind = 0;  // of the table
  double begin_mm = 0;   // along the line
  double end_mm = 0;
  double mean = 0;  // intensity
};

// Neighbouring steps of one kind are one layer. Layers thinner than thinnest_mm go, the thinnest first, to the neighbour whose mean
// intensity is nearer. Gaps before the first and behind the last tissue are left out. Throws Error (kBadInput): unknown-intensity,
// no-tissue.
[[nodiscard]] std::vector<TissueLayer> layers_of(const LineProfile& profile,
                                                 const std::vector<TissueKind>& kinds, double thinnest_mm);

}  // namespace thimble::host
