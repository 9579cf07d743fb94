#include "control/contact/world.h"

#include <algorithm>

#include "control/bodies/collide.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

PlacedObject place(const scene::Object& object) {
  PlacedObject placed;
  placed.source = &object;
  placed.row = &shape_row(object.shape_type());
  placed.ops = placed.row->solid;
  placed.ops->view(object, placed.shape);
  const scene::Quat& q = object.pose()->rotation();
  placed.rotation = to_rotation(q).toRotationMatrix();
  placed.turned = q.x() != 0.0F || q.y() != 0.0F || q.z() != 0.0F;
  placed.position_m = to_vec(object.pose()->position_m());
  placed.shaded = placed.shape.mesh.corner_normals != nullptr;
  placed.surfaced = object.surface() != nullptr;
  placed.plain = !placed.shaded && !placed.surfaced;
  place_box(placed);
  placed.half_space = placed.row->collision->form == CollisionForm::kHalfSpace;
  if (placed.half_space) {
    placed.normal = placed.turn(placed.shape.vector);
    placed.offset_m = placed.shape.radius_m + placed.normal.dot(placed.position_m);
  }
  placed.material = view_material(*object.material());
  return placed;
}

}  // namespace

Material view_material(const scene::Material& m) noexcept {
  return {m.stiffness_n_per_m(), m.damping_n_s_per_m(), m.static_friction(), m.dynamic_friction(),
          m.friction_mode() == scene::FrictionMode::Steady};
}

void place_box(PlacedObject& object) noexcept {
  const Vec3 reach = object.ops->reach(object.shape);
  const Vec3 extent = object.turned && reach.allFinite() ? Vec3(object.rotation.cwiseAbs() * reach) : reach;
  object.lo_m = object.position_m - extent;
  object.hi_m = object.position_m + extent;
}

void World::bind(const SceneView& view) noexcept {
  count = 0;
  one_potential = true;
  any_shaded = false;
  any_bodies = false;
  any_seams = false;
  tip_radius_m = view.scene() != nullptr ? view.scene()->tip_radius_m() : 0.0F;
  margin_m = std::max(2.0F * kPointRadius_m, tip_radius_m + 2.0F * kTouchGap_m);
  if (view.scene() == nullptr) return;
  std::uint8_t in_image = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    const std::uint8_t index = in_image++;
    if (is_volume(object->shape_type())) continue;
    if (object->surface() != nullptr) surfaces[count] = view_surface(*object->surface());
    objects[count] = place(*object);
    objects[count].in_image = index;
    PlacedObject& placed = objects[count];
    placed.rolls = placed.plain && tip_radius_m > 0.0F && placed.ops->roll != nullptr;
    placed.plain = placed.plain && tip_radius_m == 0.0F;
    any_bodies = any_bodies || object->body() != nullptr;
    any_seams = any_seams || objects[count].shape.mesh.seams;
    ++count;
  }
  compare_materials();
}

// Re-point everything that refers into the image; only material values change.
void World::apply_materials(const SceneView& view) noexcept {
  std::size_t index = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    if (is_volume(object->shape_type()) || index == count) continue;
    PlacedObject& placed = objects[index];
    placed.source = object;
    placed.material = view_material(*object->material());
    placed.ops->view(*object, placed.shape);
    if (object->surface() != nullptr) surfaces[index] = view_surface(*object->surface());
    ++index;
  }
  compare_materials();
}

void World::compare_materials() noexcept {
  one_potential = true;
  any_shaded = false;
  for (std::size_t i = 0; i < count; ++i) {
    const PlacedObject& object = objects[i];
    any_shaded = any_shaded || object.shaded;
    if (object.shaded || object.surfaced ||
        object.material.stiffness_N_m != objects[0].material.stiffness_N_m)
      one_potential = false;
  }
}

}  // namespace thimble::control
