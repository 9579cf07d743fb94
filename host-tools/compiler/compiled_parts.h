// What takes long to compile and does not depend on stiffness, damping and friction: solved potentials, and meshes with their trees and
// convex pieces. A program that compiles a scene again and again, such as `thimble view` while a slider moves, hands in those of the last time.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_pieces.h"

namespace thimble::host {

struct CompiledParts {
  // Known by all that it was compiled from.
  struct Mesh {
    TriangleSoup soup;
    MeshOptions options;
    bool in_pieces = false;
    CompiledMesh mesh;
    MeshPieces pieces;  // of a mesh that moves
  };
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::map<std::string, std::shared_ptr<const std::vector<float>>>
      potentials;  // coefficients by potential_key()
};

// Whether compile_mesh() would give the same.
[[nodiscard]] bool is_same(const TriangleSoup& a, const TriangleSoup& b);
[[nodiscard]] bool is_same(const MeshOptions& a, const MeshOptions& b);

}  // namespace thimble::host
