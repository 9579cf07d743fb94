// A volume of voxels from a NIfTI-1 file: header, data and the transform from voxels to the scanner's world.
//
// Read: single files (.nii, .nii.gz; magic "n+1"), either byte order, 3 dimensions (more when they are 1), integers of 1 to 8 bytes and
// floats of 4 and 8, scaled by scl_slope and scl_inter. Refused with a named Error (kBadInput): header-and-image pairs, NIfTI-2, complex
// and colour voxels, truncated files. Source: nifti1.h of the NIfTI Data Format Working Group, 2007.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace thimble::host {

// Of the data after decompression.
inline constexpr std::size_t kMaxVolumeBytes = std::size_t{2} << 30U;

class Volume {
 public:
  // Throws Error: missing-volume, not-nifti, unsupported-volume, bad-volume, truncated-volume.
  [[nodiscard]] static Volume read(const std::filesystem::path& file);

  [[nodiscard]] const Eigen::Vector3i& size() const { return size_; }  // voxels along i, j, k
  [[nodiscard]] const Eigen::Affine3d& world() const {
    return world_mm_;
  }                                                              // a voxel's centre (i, j, k) in mm
  [[nodiscard]] const char* type() const { return type_name_; }  // "int16"
  [[nodiscard]] const char* frame() const {
    return frame_name_;
  }  // "sform", "qform" or "pixdim": where world() is from
  [[nodiscard]] bool holds(const Eigen::Vector3i& voxel) const {
    return (voxel.array() >= 0).all() && (voxel.array() < size_.array()).all();
  }
  // The scaled value of a voxel that the volume holds.
  [[nodiscard]] double at(const Eigen::Vector3i& voxel) const;

 private:
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  Eigen::Affine3d world_mm_ = Eigen::Affine3d::Identity();
  const char* type_name_ = "";
  const char* frame_name_ = "";
  int type_ = 0;
  bool swapped_ = false;
  double slope_ = 1.0;
  double offset_ = 0.0;
  std::vector<unsigned char> bytes_;  // the whole file, decompressed
  std::size_t begin_ = 0;             // of the voxels
};

}  // namespace thimble::host
