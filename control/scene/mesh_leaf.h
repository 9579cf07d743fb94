// A leaf among the children of a mesh's tree, as scene.fbs packs it: up to 8 triangles that follow one
// another.
#pragma once

#include <cstdint>

namespace thimble::control {

inline constexpr std::uint32_t kLeafBit = 0x80000000U;

[[nodiscard]] constexpr bool is_leaf(std::uint32_t child) noexcept { return (child & kLeafBit) != 0; }
[[nodiscard]] constexpr std::uint32_t first_triangle(std::uint32_t leaf) noexcept {
  return (leaf & ~kLeafBit) >> 3U;
}
[[nodiscard]] constexpr std::uint32_t triangle_count(std::uint32_t leaf) noexcept { return (leaf & 7U) + 1; }
[[nodiscard]] constexpr std::uint32_t leaf_of(std::uint32_t first, std::uint32_t count) noexcept {
  return kLeafBit | (first << 3U) | (count - 1);
}

}  // namespace thimble::control
