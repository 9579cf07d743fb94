// The corners of a mesh's triangles, joined round their vertices: what they have in common, and their mean normals. Used by
// compile_mesh for pseudonormals, shading and textures.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host-tools/compiler/disjoint_sets.h"
#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

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
