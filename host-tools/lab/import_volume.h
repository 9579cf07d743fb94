// `thimble import volume`: makes a scene from the path of a needle through a scanned volume (paper, section 6, MRI demonstration).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/lab/tissue_layers.h"

namespace thimble::host {

struct ImportChoice {
  std::filesystem::path volume;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();  // mm of the volume's world, or voxel indices
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  bool in_voxels = false;
  std::optional<std::filesystem::path> table;  // without: classes by k-means
  std::size_t classes = 4;
  double thinnest_mm = 2.0;
};

struct ImportedNeedle {
  std::vector<TissueKind> kinds;
  std::vector<TissueLayer> layers;
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mm = Eigen::Vector3d::Zero();
  std::string voxel_type;
  std::string frame;
  std::string scene;  // the scene file's text, which compiles
};

// Throws Error (kBadInput): those of Volume, profile_along, layers_of and read_tissue_table; too-many-layers.
[[nodiscard]] ImportedNeedle import_volume(const ImportChoice& choice);

}  // namespace thimble::host
