// Where the objects of a scene image are, as boxes: whether an arm can touch them at all.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace thimble::host {

// A turned box, in the world's frame and metres, around the object where it starts. Sides may be infinite: those of a plane.
struct ObjectRegion {
  std::string name;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the box in the world
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d lo_m = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Vector3d hi_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());

  // The point of the box that is nearest to p_m, world frame.
  [[nodiscard]] Eigen::Vector3d nearest(const Eigen::Vector3d& p_m) const {
    const Eigen::Vector3d inside = (rotation.transpose() * (p_m - origin_m)).cwiseMax(lo_m).cwiseMin(hi_m);
    return origin_m + rotation * inside;
  }
};

// The solid of a plane, the block of a tissue and the track of a needle without end downwards. None of an image that is not valid.
[[nodiscard]] std::vector<ObjectRegion> object_regions(std::span<const std::byte> image);

}  // namespace thimble::host
