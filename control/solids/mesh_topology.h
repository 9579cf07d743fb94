// Navigation on a mesh: from corner to corner, over edges, around vertices; and the side of a face that a
// point is on.
//
// All functions take a triangle of a checked image. None can fail or exceed its named bound.
#pragma once

#include <cstdint>

#include "control/scene/mesh_triangle.h"
#include "control/solids/mesh_view.h"
#include "control/solids/solid.h"

namespace thimble::control::topology {

inline constexpr int kMaxFan = 512;  // faces round one vertex

inline constexpr std::uint8_t kFace = 0;
inline constexpr std::uint8_t kEdge = 1;
inline constexpr std::uint8_t kVertex = 2;

constexpr std::uint32_t next(std::uint32_t corner) { return corner == 2 ? 0 : corner + 1; }
constexpr std::uint32_t previous(std::uint32_t corner) { return corner == 0 ? 2 : corner - 1; }

inline std::uint32_t vertex_index(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner) {
  return vertex_of(mesh.triangles[triangle], corner);
}

inline Vec3 vertex(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner) {
  return to_vec(mesh.vertices[vertex_index(mesh, triangle, corner)].position_m());
}

// A unit vector, on the side given by the winding.
[[nodiscard]] Vec3 pseudonormal(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner);

inline bool two_sided(const MeshView& mesh, std::uint32_t triangle) {
  return (mesh.flags[triangle] & static_cast<std::uint8_t>(scene::TriangleFlag::TwoSided)) != 0;
}

// Whether a slide over the triangle is swept.
inline bool pierced(const MeshView& mesh, std::uint32_t triangle) {
  constexpr auto kSwept = static_cast<std::uint8_t>(scene::TriangleFlag::Pierced) |
                          static_cast<std::uint8_t>(scene::TriangleFlag::Seam);
  return (mesh.flags[triangle] & kSwept) != 0;
}

// Twice the area times the unit normal, on the side given by the winding.
inline Vec3 area_normal(const MeshView& mesh, std::uint32_t triangle) {
  const Vec3 a = vertex(mesh, triangle, 0);
  return (vertex(mesh, triangle, 1) - a).cross(vertex(mesh, triangle, 2) - a);
}

// Whether p is on the given side of the triangle's plane. It depends on the point alone, so two ticks that
// share a point agree on its side and there is no gap between them.
inline bool in_front(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, const Vec3& p) {
  const bool front = area_normal(mesh, triangle).dot(p - vertex(mesh, triangle, 0)) >= 0.0F;
  return front == (side > 0);
}

// A triangle seen from one side, and its neighbours on that side. At the rim of a sheet the neighbour is the
// other side of the same triangle, because a sheet is a solid without thickness.
struct Step {
  std::uint32_t triangle;
  std::uint32_t edge;  // of the edge that was crossed
  std::int8_t side;
};

inline Step across(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, std::uint32_t edge) {
  const std::uint32_t beyond = edge_beyond(mesh.triangles[triangle], edge);
  if (beyond == kNoEdge) return {triangle, edge, static_cast<std::int8_t>(-side)};
  const std::uint32_t other = beyond / 3;
  const std::uint32_t other_edge = beyond % 3;
  const bool same_direction = vertex_index(mesh, other, other_edge) == vertex_index(mesh, triangle, edge);
  return {other, other_edge, same_direction ? static_cast<std::int8_t>(-side) : side};
}

// Around a vertex: the edge to cross next, always in the same direction of rotation in space.
inline std::uint32_t fan_edge(std::uint32_t corner, std::int8_t side) {
  return side > 0 ? previous(corner) : corner;
}

struct Corner {
  std::uint32_t triangle;
  std::uint32_t corner;
  std::int8_t side;
};

[[nodiscard]] Corner next_in_fan(const MeshView& mesh, const Corner& at);

// Whether the corner between a face and the face beyond one of its edges opens towards their free side by
// less than 180 degrees.
inline bool concave(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, const Step& beyond) {
  if (beyond.triangle == triangle) return false;  // round the rim of a sheet
  return in_front(mesh, triangle, side, vertex(mesh, beyond.triangle, previous(beyond.edge)));
}

}  // namespace thimble::control::topology
