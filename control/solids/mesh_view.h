// A mesh of the scene image, read in place.
#pragma once

#include <cstdint>

#include "kinematics/vector.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

inline Vec3 to_vec(const scene::Vec3& v) noexcept { return {v.x(), v.y(), v.z()}; }

struct MeshView {
  const scene::Vertex* vertices = nullptr;
  const scene::Triangle* triangles = nullptr;
  const std::uint8_t* flags = nullptr;
  const std::uint32_t* corner_normals = nullptr;  // null: faceted
  const scene::BvhNode* nodes = nullptr;
  Vec3 grid_origin_m = Vec3::Zero();
  float grid_step_m = 1.0F;
  float grid_scale = 1.0F;  // 1 / grid_step_m
};

[[nodiscard]] MeshView view_mesh(const scene::Mesh& mesh) noexcept;

}  // namespace thimble::control
