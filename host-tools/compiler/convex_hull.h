// The convex hull of points, by Qhull.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace thimble::host {

struct HullFace {  // the hull is where normal . p <= offset_m
  Eigen::Vector3d normal;
  double offset_m;
};

struct Hull {
  std::vector<Eigen::Vector3d> corners;
  std::vector<HullFace> faces;
  double volume_m3 = 0;
};

// Empty where the points lie in a plane.
[[nodiscard]] Hull hull_of(std::vector<Eigen::Vector3d> points);

}  // namespace thimble::host
