// Synthetic volumes as NIfTI-1 files, written field by field from the standard, without the reader's code.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <vector>

namespace thimble::test {

struct NiftiFile {
  Eigen::Vector3i size{24, 20, 40};
  int type = 4;  // NIfTI-1 data type code
  bool big_endian = false;
  bool compressed = false;
  enum class Frame { kSform, kQform, kPixdim } frame = Frame::kSform;
  // Voxel to mm. For kQform: rotation times edges, k turned round where the determinant is negative; for
  // kPixdim: edges alone.
  Eigen::Affine3d world = Eigen::Affine3d::Identity();
  unsigned units = 2;  // 1 m, 2 mm, 3 um: what the file's numbers are in
  double slope = 0.0;  // as written; stored value = (value - offset) / slope where it is not 0
  double offset = 0.0;
  std::function<double(const Eigen::Vector3d& p_mm)> value = [](const Eigen::Vector3d&) { return 0.0; };
};

// The bytes before compression.
[[nodiscard]] std::vector<unsigned char> nifti_bytes(const NiftiFile& file);
void write_bytes(const std::filesystem::path& path, const std::vector<unsigned char>& bytes, bool compressed);
void write_nifti(const std::filesystem::path& path, const NiftiFile& file);

}  // namespace thimble::test
