#include <array>
#include <cstdint>

#include "control/scene/blend.h"
#include "control/scene/check.h"
#include "control/scene/mesh_leaf.h"
#include "control/scene/mesh_triangle.h"

namespace thimble::control {
namespace {

constexpr std::uint32_t after(std::uint32_t corner) { return corner == 2 ? 0 : corner + 1; }

ImageVerdict check_triangles(const scene::Mesh& mesh, Pauses& pauses) {
  const std::uint32_t vertices = mesh.vertices()->size();
  const std::uint32_t triangles = mesh.triangles()->size();
  for (std::uint32_t i = 0; i < triangles; ++i) {
    pauses.step();
    const scene::Triangle& triangle = *mesh.triangles()->Get(i);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      if (vertex_of(triangle, corner) >= vertices ||
          vertex_of(triangle, corner) == vertex_of(triangle, after(corner)))
        return ImageStatus::kBadIndex;
    }
  }
  // A neighbour shares the edge, so a walk over the surface is continuous.
  for (std::uint32_t i = 0; i < triangles; ++i) {
    pauses.step();
    const scene::Triangle& triangle = *mesh.triangles()->Get(i);
    for (std::uint32_t edge = 0; edge < 3; ++edge) {
      const std::uint32_t beyond = edge_beyond(triangle, edge);
      if (beyond == kNoEdge) continue;
      const std::uint32_t neighbour = beyond / 3;
      const std::uint32_t there = beyond % 3;
      if (neighbour >= triangles || neighbour == i) return ImageStatus::kBadIndex;
      const scene::Triangle& other = *mesh.triangles()->Get(neighbour);
      const std::uint32_t a = vertex_of(triangle, edge);
      const std::uint32_t b = vertex_of(triangle, after(edge));
      const std::uint32_t c = vertex_of(other, there);
      const std::uint32_t d = vertex_of(other, after(there));
      if (!((a == c && b == d) || (a == d && b == c))) return ImageStatus::kBadIndex;
    }
  }
  return ImageStatus::kOk;
}

// Walks the whole tree: every node once, not deeper than the stack of a sweep, every leaf within the
// triangles.
ImageVerdict check_tree(const scene::Mesh& mesh, Pauses& pauses) {
  const std::uint32_t nodes = mesh.nodes()->size();
  const std::uint32_t triangles = mesh.triangles()->size();
  std::array<std::uint32_t, kMaxBvhDepth> stack{};
  std::size_t depth = 0;
  stack[depth++] = 0;
  for (std::uint32_t visited = 0; depth > 0; ++visited) {
    pauses.step();
    if (visited == nodes) return ImageStatus::kBadTree;
    const std::uint32_t at = stack[--depth];
    const auto& child = *mesh.nodes()->Get(at)->child();
    for (std::uint16_t c = 0; c < 2; ++c) {
      if (c == 1 && child[1] == child[0]) break;  // a node with one child repeats it
      if (is_leaf(child[c])) {
        const std::uint32_t first = first_triangle(child[c]);
        if (first >= triangles || triangle_count(child[c]) > triangles - first) return ImageStatus::kBadTree;
        continue;
      }
      if (child[c] <= at || child[c] >= nodes || depth == stack.size()) return ImageStatus::kBadTree;
      stack[depth++] = child[c];
    }
  }
  return ImageStatus::kOk;
}

ImageVerdict check_texture_points(const scene::Mesh& mesh, Pauses& pauses) {
  const auto* corners = mesh.texture_corners();
  const auto* points = mesh.texture_points();
  if (corners == nullptr && points == nullptr) return ImageStatus::kOk;
  if (corners == nullptr || points == nullptr || corners->size() != std::size_t{3} * mesh.triangles()->size())
    return ImageStatus::kBadIndex;
  for (const std::uint32_t corner : *corners) {
    pauses.step();
    if (corner >= points->size()) return ImageStatus::kBadIndex;
  }
  const auto is_gradient = [](const scene::Vec3& v) {
    constexpr float kMost = kMaxTextureGradient;
    return in_range(v.x(), -kMost, kMost) && in_range(v.y(), -kMost, kMost) && in_range(v.z(), -kMost, kMost);
  };
  for (const scene::TexturePoint* point : *points) {
    pauses.step();
    if (!in_range(point->u_m(), -kMaxCoordinate_m, kMaxCoordinate_m) ||
        !in_range(point->v_m(), -kMaxCoordinate_m, kMaxCoordinate_m) ||
        !in_range(point->strength(), 0.0F, 1.0F) || !is_gradient(point->du()) || !is_gradient(point->dv()))
      return ImageStatus::kBadNumber;
  }
  return ImageStatus::kOk;
}

ImageVerdict check_texture_weights(const scene::Mesh& mesh, Pauses& pauses) {
  const auto* weights = mesh.texture_weights();
  if (weights == nullptr) return ImageStatus::kOk;
  if (weights->size() != std::size_t{3} * mesh.triangles()->size()) return ImageStatus::kBadIndex;
  for (std::uint32_t i = 0; i < weights->size(); i += 3) {
    pauses.step();
    const bool own_axes = weights->Get(i) == kOwnAxes;
    for (std::uint32_t corner = i; corner < i + 3; ++corner) {
      const std::uint32_t code = weights->Get(corner);
      if (own_axes ? code != kOwnAxes : (code & 0xFFFFU) + (code >> 16U) > 0xFFFFU)
        return ImageStatus::kBadNumber;
    }
  }
  return ImageStatus::kOk;
}

// The convex pieces: none, or from 1 to kMaxPieces with enough corners each.
ImageVerdict check_pieces(const scene::Mesh& mesh) {
  const std::size_t pieces = mesh.piece_ends() != nullptr ? mesh.piece_ends()->size() : 0;
  const std::size_t corners = mesh.piece_corners() != nullptr ? mesh.piece_corners()->size() : 0;
  RETURN_IF_BAD(at_most(kMaxPieces, pieces, "pieces of a mesh", ImageStatus::kTooManySamples));
  std::size_t begin = 0;
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::size_t end = mesh.piece_ends()->Get(static_cast<flatbuffers::uoffset_t>(i));
    if (end < begin + kMinPieceCorners || end > begin + kMaxPieceCorners) return ImageStatus::kBadIndex;
    begin = end;
  }
  if (begin != corners) return ImageStatus::kBadIndex;
  for (std::size_t i = 0; i < corners; ++i) {
    if (!is_coordinate(*mesh.piece_corners()->Get(static_cast<flatbuffers::uoffset_t>(i))))
      return ImageStatus::kBadNumber;
  }
  return ImageStatus::kOk;
}

}  // namespace

ImageVerdict check_mesh(const scene::Mesh& mesh, std::size_t& triangles_in_scene, Pauses& pauses) noexcept {
  const std::uint32_t triangles = mesh.triangles()->size();
  triangles_in_scene += triangles;
  RETURN_IF_BAD(at_most(kMaxTriangles, triangles_in_scene, "triangles", ImageStatus::kTooManyTriangles));
  if (triangles == 0 || mesh.vertices()->size() == 0 || mesh.nodes()->size() == 0)
    return ImageStatus::kBadIndex;
  if (mesh.flags()->size() != triangles) return ImageStatus::kBadIndex;
  if (mesh.corner_normals() != nullptr && mesh.corner_normals()->size() != std::size_t{3} * triangles) {
    return ImageStatus::kBadIndex;
  }
  if (mesh.rims() != nullptr && mesh.rims()->size() != std::size_t{3} * triangles)
    return ImageStatus::kBadIndex;
  if (mesh.grid_origin_m() == nullptr || !is_coordinate(*mesh.grid_origin_m()))
    return ImageStatus::kBadNumber;
  constexpr float kSmallestStep_m = 1.0e-12F;
  if (!in_range(mesh.grid_step_m(), kSmallestStep_m, kMaxCoordinate_m)) return ImageStatus::kBadNumber;
  for (const scene::Vertex* vertex : *mesh.vertices()) {
    pauses.step();
    if (!is_coordinate(vertex->position_m())) return ImageStatus::kBadNumber;
  }
  RETURN_IF_BAD(check_triangles(mesh, pauses));
  RETURN_IF_BAD(check_pieces(mesh));
  RETURN_IF_BAD(check_texture_weights(mesh, pauses));
  RETURN_IF_BAD(check_texture_points(mesh, pauses));
  return check_tree(mesh, pauses);
}

}  // namespace thimble::control
