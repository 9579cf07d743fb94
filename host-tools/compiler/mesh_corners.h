// The corners of a mesh's triangles, joined round their vertices: what they have in common, and their mean normals. Used by
// compile_mesh for pseudonormals, shading and textures.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

// Disjoint sets; the lowest member names the set, so the result does not depend on the order of joining.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// Joins the corners on either side of each edge that `passes`: a set is then a fan of triangles round a
// vertex.
template <typename Passes>
DisjointSets join_corners(const Adjacency& adjacency, Passes&& passes) {
  DisjointSets fans(adjacency.neighbour.size());
  for (std::uint32_t corner = 0; corner < adjacency.neighbour.size(); ++corner) {
    const std::uint32_t code = adjacency.neighbour[corner];
    if (code == kNoNeighbour || !passes(corner / 3, code >> 2U)) {
      continue;
    }
    // Edge e runs from corner e; the neighbour's edge runs the other way.
    const std::uint32_t other = 3 * (code >> 2U);
    fans.join(corner, other + next_edge(code & 3U));
    fans.join(3 * (corner / 3) + next_edge(corner % 3), other + (code & 3U));
  }
  return fans;
}

// The angle-weighted sum of the faces' normals over each set of corners, as a unit vector at the set's name.
[[nodiscard]] std::vector<Eigen::Vector3d> mean_normals(const Surface& surface,
                                                        const std::vector<Eigen::Vector3d>& face_normals,
                                                        DisjointSets& sets);

}  // namespace thimble::host
