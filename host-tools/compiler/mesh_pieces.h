// Convex pieces of a closed mesh: what a mesh that moves collides as (control/bodies/collide.h).
//
// The mesh is cut by planes across its axes, each time the part whose hull exceeds its solid most, where the two hulls
// are smallest together (compare Lien and Amato 2007; Wei, Liu, Ling and Su 2022). Qhull makes the hulls. A hull with
// too many corners becomes the hull of those that leave the least of it out.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

struct MeshPieces {
  std::vector<std::vector<Eigen::Vector3d>> corners_m;  // of each piece
  double excess = 0;      // volume of the pieces beyond the mesh's, as a part of the mesh's
  double left_out_m = 0;  // how far the mesh reaches out of the pieces at most
};

// Deterministic. Empty for a mesh that encloses no volume.
[[nodiscard]] MeshPieces convex_pieces(const CompiledMesh& mesh);

}  // namespace thimble::host
