// Winding and adjacency of a clean surface. The second step of compile_mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

inline constexpr std::uint32_t kNoNeighbour = 0xFFFFFFFFU;
inline constexpr std::uint32_t kOpenPart = 0xFFFFFFFFU;

struct Adjacency {
  std::vector<std::uint32_t> neighbour;  // 3 a triangle: 4 * triangle + edge across edge e, or kNoNeighbour
  std::vector<char> open;                // of each triangle: it belongs to a component with an open edge
  std::vector<char> crowded;             // of each triangle: one of its edges has more than two faces
  // Of each triangle: the closed part that it belongs to, or kOpenPart. Where parts touch in an edge, each is closed in itself.
  std::vector<std::uint32_t> part;
};

// Winds the surface's triangles (in the tree's order): alike within each component, closed components
// outwards, cavities inwards, open ones as most of their area in the file; then all of them the other way
// when `inside_out`. At an edge with more than two faces each face is paired with the next one around the
// edge on its front side.
[[nodiscard]] Adjacency orient(Surface& surface, const MeshTree& tree, bool inside_out, MeshReport& report);

}  // namespace thimble::host
