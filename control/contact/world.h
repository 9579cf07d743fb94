// The solid objects of a scene as the tick needs them: poses, bounds, materials. Filled once by bind().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "control/scene/shape_table.h"
#include "control/solids/solid.h"
#include "control/surfaces/surface_view.h"
#include "kinematics/vector.h"

namespace thimble::control {

struct Material {
  float stiffness_N_m = 0.0F;
  float damping_N_s_m = 0.0F;
  float static_friction = 0.0F;
  float dynamic_friction = 0.0F;
  bool steady = false;  // friction_mode "steady"
};

[[nodiscard]] Material view_material(const scene::Material& material) noexcept;
inline constexpr std::uint8_t kNoBody = 0xFF;

struct PlacedObject {
  const scene::Object* source = nullptr;  // in the image: its surface and body
  const ShapeRow* row = nullptr;
  const SolidOps* ops = nullptr;  // of the row
  ShapeData shape;
  Mat3 rotation = Mat3::Identity();  // object to world
  Vec3 position_m = Vec3::Zero();
  bool turned = false;
  bool shaded = false;
  bool surfaced = false;  // with a click, a brake, a texture or a stiffness map
  // Allowed in the renderer's fast path: not shaded, not surfaced, not a body, and the tip is a point; or it is a ball, and this is a
  // mesh.
  bool plain = true;
  bool rolls = false;
  std::uint8_t body = kNoBody;  // its index among the bodies (control/bodies)
  std::uint8_t in_image = 0;    // its index in the scene image
  Vec3 lo_m = Vec3::Zero();     // axis-aligned bounding box, world frame
  Vec3 hi_m = Vec3::Zero();
  // A half-space has no box: it is behind this plane of the world frame, and does not move.
  bool half_space = false;
  Vec3 normal = Vec3::UnitZ();
  float offset_m = 0.0F;
  Material material;

  [[nodiscard]] Vec3 to_local(const Vec3& p) const { return turn_back(p - position_m); }
  [[nodiscard]] Vec3 to_world(const Vec3& p) const { return turn(p) + position_m; }
  [[nodiscard]] Vec3 turn(const Vec3& v) const { return turned ? Vec3(rotation * v) : v; }
  [[nodiscard]] Vec3 turn_back(const Vec3& v) const { return turned ? Vec3(rotation.transpose() * v) : v; }
};

// Sets lo_m and hi_m for the present pose.
void place_box(PlacedObject& object) noexcept;

// The solids of a scene. Volumes have no surface and are not among them: control/fields renders them.
struct World {
  std::array<PlacedObject, kMaxObjects> objects;
  std::array<SurfaceView, kMaxObjects> surfaces;  // of those that are surfaced
  std::size_t count = 0;
  // All have the same stiffness, and none is shaded or surfaced: the force of every contact is the gradient of one
  // potential, and needs no energy account.
  bool one_potential = true;
  bool any_shaded = false;
  bool any_bodies = false;    // objects that move
  bool any_seams = false;     // a mesh of several parts that touch
  float tip_radius_m = 0.0F;  // above 0: each fingertip is a sphere, and a god object is its centre
  // A solid farther than this from all moves of a god object cannot touch it.
  float margin_m = 2.0F * kPointRadius_m;

  [[gnu::cold]] void bind(const SceneView& view) noexcept;
  [[gnu::cold]] void apply_materials(const SceneView& view) noexcept;  // Binding::kKeepState

 private:
  void compare_materials() noexcept;
};

}  // namespace thimble::control
