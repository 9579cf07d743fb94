// Ray queries by Embree: an independent judge of how often a mesh winds round a point. In single
// precision, with Embree's robust traversal: exact to about 1e-7 of the mesh's size.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::test {

class EmbreeOracle {
 public:
  explicit EmbreeOracle(const host::TriangleSoup& soup);  // may be empty
  ~EmbreeOracle();
  EmbreeOracle(const EmbreeOracle&) = delete;
  EmbreeOracle& operator=(const EmbreeOracle&) = delete;

  // How often closed faces wind round p: the faces that a ray meets, with their signs. The median of three rays, so that one
  // ray through an edge is outvoted.
  [[nodiscard]] int winding(const Eigen::Vector3d& p) const;

  // Whether one of 14 rays from p meets nothing.
  [[nodiscard]] bool in_the_open(const Eigen::Vector3d& p) const;

 private:
  [[nodiscard]] bool crosses(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  [[nodiscard]] int signed_hits(const Eigen::Vector3f& from, const Eigen::Vector3f& direction) const;

  RTCDevice device_;
  RTCScene scene_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace thimble::test
