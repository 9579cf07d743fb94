#include "control/contact/world.h"

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

ShapeData view_shape(const scene::Object& object) {
  ShapeData data;
  switch (object.shape_type()) {
    case scene::Shape::NONE:
    case scene::Shape::VectorField:
    case scene::Shape::PotentialField:
    case scene::Shape::Needle:
    case scene::Shape::Tissue:
      break;
    case scene::Shape::Plane:
      data.vector = to_vec(object.shape_as_Plane()->normal()).normalized();
      data.radius_m = object.shape_as_Plane()->offset_m();
      break;
    case scene::Shape::Sphere:
      data.radius_m = object.shape_as_Sphere()->radius_m();
      break;
    case scene::Shape::Box:
      data.vector = to_vec(object.shape_as_Box()->half_size_m());
      break;
    case scene::Shape::Cylinder:
      data.radius_m = object.shape_as_Cylinder()->radius_m();
      data.half_height_m = object.shape_as_Cylinder()->half_height_m();
      break;
    case scene::Shape::Capsule:
      data.radius_m = object.shape_as_Capsule()->radius_m();
      data.half_height_m = object.shape_as_Capsule()->half_height_m();
      break;
    case scene::Shape::Mesh:
      data.mesh = view_mesh(*object.shape_as_Mesh());
      break;
  }
  return data;
}

PlacedObject place(const scene::Object& object) {
  PlacedObject placed;
  placed.source = &object;
  placed.ops = &shape_ops(object.shape_type());
  placed.shape = view_shape(object);
  const scene::Quat& q = object.pose()->rotation();
  placed.rotation = Eigen::Quaternionf(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  placed.turned = q.x() != 0.0F || q.y() != 0.0F || q.z() != 0.0F;
  placed.position_m = to_vec(object.pose()->position_m());
  placed.shaded = placed.shape.mesh.corner_normals != nullptr;
  placed.surfaced = object.surface() != nullptr;
  placed.plain = !placed.shaded && !placed.surfaced;
  place_box(placed);
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
  if (view.scene() == nullptr) return;
  for (const scene::Object* object : *view.scene()->objects()) {
    if (is_volume(object->shape_type())) continue;
    if (object->surface() != nullptr) surfaces[count] = view_surface(*object->surface());
    objects[count++] = place(*object);
  }
}

// What lies in the image is elsewhere now; of all else the materials alone are new.
void World::go_on(const SceneView& view) noexcept {
  std::size_t index = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    if (is_volume(object->shape_type()) || index == count) continue;
    PlacedObject& placed = objects[index];
    placed.source = object;
    placed.material = view_material(*object->material());
    if (object->shape_type() == scene::Shape::Mesh) placed.shape.mesh = view_mesh(*object->shape_as_Mesh());
    if (object->surface() != nullptr) surfaces[index] = view_surface(*object->surface());
    ++index;
  }
}

}  // namespace thimble::control
