// A mesh of the scene image, read in place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinematics/vector.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

inline Vec3 to_vec(const scene::Vec3& v) noexcept { return {v.x(), v.y(), v.z()}; }
inline Eigen::Quaternionf to_rotation(const scene::Quat& q) noexcept {
  return Eigen::Quaternionf(q.w(), q.x(), q.y(), q.z()).normalized();
}

// A place in steps of the mesh's grid.
using GridPoint = flatbuffers::Array<std::uint16_t, 3>;

struct MeshView {
  const scene::Vertex* vertices = nullptr;
  const scene::Triangle* triangles = nullptr;
  const std::uint8_t* flags = nullptr;
  const std::uint32_t* corner_normals = nullptr;  // null: faceted
  const scene::BvhNode* nodes = nullptr;
  const std::uint32_t* texture_weights = nullptr;  // null: no blending
  const std::uint32_t* texture_corners = nullptr;  // null: no coordinates of the file
  const scene::TexturePoint* texture_points = nullptr;
  const scene::Vec3* piece_corners = nullptr;  // of a mesh that moves: the convex pieces that it collides as
  const std::uint16_t* piece_ends = nullptr;
  std::size_t piece_count = 0;
  bool seams = false;
  const std::uint8_t* rims = nullptr;  // null: the tip is a point, or the compiler was an older one
  Vec3 grid_origin_m = Vec3::Zero();
  float grid_step_m = 1.0F;
  float grid_scale = 1.0F;  // 1 / grid_step_m

  [[nodiscard]] std::span<const scene::Vec3> piece(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : piece_ends[i - 1];
    return {piece_corners + begin, piece_ends[i] - begin};
  }
};

[[nodiscard]] MeshView view_mesh(const scene::Mesh& mesh) noexcept;

}  // namespace thimble::control
