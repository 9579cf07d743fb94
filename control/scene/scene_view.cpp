#include "control/scene/scene_view.h"

#include <bit>
#include <cstdint>

#include "control/scene/check.h"
#include "control/scene/limits.h"
#include "control/scene/shape_table.h"
#include "control/solids/solid.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

ImageVerdict check_material(const scene::Material& m) {
  return require(in_range(m.stiffness_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                     in_range(m.damping_n_s_per_m(), 0.0F, kMaxDamping_N_s_m) &&
                     in_range(m.static_friction(), 0.0F, kMaxFriction) &&
                     in_range(m.dynamic_friction(), 0.0F, m.static_friction()) &&
                     m.friction_mode() <= scene::FrictionMode::MAX,
                 ImageStatus::kBadNumber);
}

ImageVerdict check_pose(const scene::Pose& pose) {
  return require(is_coordinate(pose.position_m()) && is_unit(pose.rotation()), ImageStatus::kBadNumber);
}

ImageVerdict check_shape(const scene::Object& object, std::size_t& triangles_in_scene, Pauses& pauses) {
  const ShapeRow* row = find_shape(object.shape_type());
  if (row == nullptr) return ImageStatus::kNoShape;
  return row->solid != nullptr ? row->solid->check(object, triangles_in_scene, pauses)
                               : check_volume(object, *row->volume, pauses);
}

}  // namespace

ImageVerdict SceneView::check(std::span<const std::byte> bytes, SceneView& view, Pause pause) noexcept {
  RETURN_IF_BAD(at_most(kMaxImageBytes, bytes.size(), "bytes", ImageStatus::kTooLarge));
  if (std::bit_cast<std::uintptr_t>(bytes.data()) % 8 != 0) return ImageStatus::kMisaligned;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  // Scene -> object -> surface -> texture is 4 tables deep. The tables of an object: itself, its shape with
  // subvolumes, its surface with texture and map, its body with a control.
  constexpr std::size_t kDepth = 8;
  constexpr std::size_t kTables = 1 + (7 + kMaxSubvolumes) * kMaxObjects;
  flatbuffers::Verifier verifier(data, bytes.size(), kDepth, kTables);
  if (bytes.size() < 2 * sizeof(std::uint32_t) || !scene::VerifySceneBuffer(verifier))
    return ImageStatus::kNotAScene;
  const scene::Scene* scene = scene::GetScene(data);
  RETURN_IF_BAD(at_most(kMaxObjects, scene->objects()->size(), "objects", ImageStatus::kTooManyObjects));
  Pauses pauses(pause);
  std::size_t triangles = 0;
  std::size_t bodies = 0;
  std::size_t volumes = 0;
  if (scene->gravity_m_per_s2() != nullptr) {
    RETURN_IF_BAD(require(is_coordinate(*scene->gravity_m_per_s2()), ImageStatus::kBadNumber));
  }
  RETURN_IF_BAD(require(
      scene->tip_radius_m() == 0.0F || in_range(scene->tip_radius_m(), kMinTipRadius_m, kMaxTipRadius_m),
      ImageStatus::kBadNumber));
  for (const scene::Object* object : *scene->objects()) {
    if (object->shape() == nullptr) return ImageStatus::kNoShape;
    RETURN_IF_BAD(check_shape(*object, triangles, pauses));
    RETURN_IF_BAD(check_pose(*object->pose()));
    RETURN_IF_BAD(check_material(*object->material()));
    RETURN_IF_BAD(check_surface(*object, pauses));
    RETURN_IF_BAD(check_body(*object));
    if (object->body() != nullptr) ++bodies;
    if (is_volume(object->shape_type())) ++volumes;
    RETURN_IF_BAD(at_most(kMaxBodies, bodies, "objects that move", ImageStatus::kTooManyBodies));
    RETURN_IF_BAD(at_most(kMaxVolumes, volumes, "volumes", ImageStatus::kTooManyObjects));
  }
  view.scene_ = scene;
  return ImageStatus::kOk;
}

}  // namespace thimble::control
