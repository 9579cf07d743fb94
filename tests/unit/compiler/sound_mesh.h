// Invariants of every compiled mesh.
#pragma once

#include <string>

#include "host-tools/compiler/mesh.h"

namespace thimble::test {

// Empty when the mesh is sound, else the first thing wrong with it: indices, adjacency both ways along
// reversed edges, one fan a vertex, unit normals, every triangle in one leaf and inside its boxes, children
// after parents, depth, report.
[[nodiscard]] std::string unsound(const host::CompiledMesh& mesh);

// Signed volume of the triangles as they are wound.
[[nodiscard]] double volume_m3(const host::CompiledMesh& mesh);

[[nodiscard]] Eigen::Vector3d position(const host::CompiledMesh& mesh, std::uint32_t vertex);
[[nodiscard]] std::size_t count_flag(const host::CompiledMesh& mesh, scene::TriangleFlag flag);

// The same vertices, triangles, flags, corner normals and tree, byte for byte.
[[nodiscard]] bool same_bytes(const host::CompiledMesh& a, const host::CompiledMesh& b);

}  // namespace thimble::test
