// The effects of an object's surface as the tick needs them. The grids stay in the scene image and are read
// in place. Filled by World::bind().
#pragma once

#include <cstdint>

#include "control/solids/mesh_view.h"
#include "kinematics/vector.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

struct ClickView {
  float amplitude_N = 0.0F;  // of an impact at 0.1 m/s; 0: none
  float frequency_Hz = 0.0F;
  float decay_per_s = 0.0F;
};

struct TextureView {
  const float* height_m = nullptr;  // null: none
  scene::TextureKind kind = scene::TextureKind::Lateral;
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  float columns_per_m = 0.0F;
  float rows_per_m = 0.0F;
};

struct StiffnessMapView {
  const float* stiffness_N_m = nullptr;  // null: none
  const float* damping_N_s_m = nullptr;  // null: the material's
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  float cells_per_m = 0.0F;
  Vec3 origin_m = Vec3::Zero();
  Vec3 u = Vec3::Zero();
  Vec3 v = Vec3::Zero();
  bool conservative = false;
};

struct SurfaceView {
  ClickView click;
  float brake_friction = 0.0F;
  TextureView texture;
  StiffnessMapView map;
};

[[nodiscard]] SurfaceView view_surface(const scene::Surface& surface) noexcept;

}  // namespace thimble::control
