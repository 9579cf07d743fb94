// The references of a triangle of a mesh, as scene.fbs packs them: to its vertices, and over its edges. Edges are counted through all
// triangles: 3 * triangle + edge. No failure: any bits give a number, which check_mesh compares with what is there.
#pragma once

#include <array>
#include <cstdint>

#include "control/scene/limits.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

inline constexpr std::uint32_t kVertexBits = 20;
inline constexpr std::uint32_t kEdgeBits = 22;
inline constexpr std::uint32_t kLowEdgeBits =
    32 - kVertexBits;  // beside a vertex; the others are in the last word
inline constexpr std::uint32_t kHighEdgeBits = kEdgeBits - kLowEdgeBits;
inline constexpr std::uint32_t kNoEdge = (1U << kEdgeBits) - 1U;  // where the sheet ends
static_assert(kMaxVertices == 1U << kVertexBits && 3 * kMaxTriangles <= kNoEdge && 3 * kHighEdgeBits <= 32);

[[nodiscard]] inline std::uint32_t vertex_of(const scene::Triangle& triangle, std::uint32_t corner) noexcept {
  return (*triangle.bits())[static_cast<std::uint16_t>(corner)] & ((1U << kVertexBits) - 1U);
}

// The edge of the neighbour across this edge, or kNoEdge.
[[nodiscard]] inline std::uint32_t edge_beyond(const scene::Triangle& triangle, std::uint32_t edge) noexcept {
  const std::uint32_t low = (*triangle.bits())[static_cast<std::uint16_t>(edge)] >> kVertexBits;
  const std::uint32_t high = (*triangle.bits())[3] >> (kHighEdgeBits * edge);
  return low | (high & ((1U << kHighEdgeBits) - 1U)) << kLowEdgeBits;
}

[[nodiscard]] inline scene::Triangle pack_triangle(const std::array<std::uint32_t, 3>& vertices,
                                                   const std::array<std::uint32_t, 3>& beyond) noexcept {
  std::array<std::uint32_t, 4> bits{};
  for (std::uint32_t i = 0; i < 3; ++i) {
    bits[i] = vertices[i] | beyond[i] << kVertexBits;
    bits[3] |= beyond[i] >> kLowEdgeBits << (kHighEdgeBits * i);
  }
  return scene::Triangle(flatbuffers::span<const std::uint32_t, 4>(bits));
}

}  // namespace thimble::control
