#include "host-tools/lab/scene_tree.h"

#include "host-tools/compiler/object_regions.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

double exact(float value) { return static_cast<double>(value); }

std::string word_of(scene::Motion motion) {
  switch (motion) {
    case scene::Motion::Free:
      return "free";
    case scene::Motion::Translate:
      return "translate";
    case scene::Motion::Plane:
      return "plane";
    case scene::Motion::Slide:
      return "slide";
    case scene::Motion::Turn:
      return "turn";
  }
  return "";
}

template <class Vector>
std::size_t bytes_of(const Vector* vector) {
  return vector == nullptr ? 0 : vector->size() * sizeof(float);
}

void add_surface(const scene::Surface& surface, SceneTreeObject& object) {
  if (surface.click() != nullptr) object.effects.emplace_back("click");
  if (surface.brake_friction() > 0) object.effects.emplace_back("brake");
  if (surface.texture() != nullptr) {
    object.effects.emplace_back("texture");
    object.bytes += bytes_of(surface.texture()->height_m());
  }
  if (surface.stiffness_map() != nullptr) {
    object.effects.emplace_back("stiffness map");
    object.bytes += bytes_of(surface.stiffness_map()->stiffness_n_per_m()) +
                    bytes_of(surface.stiffness_map()->damping_n_s_per_m());
  }
}

void add_body(const scene::Body& body, SceneTreeObject& object) {
  object.motion = word_of(body.motion());
  object.mass_kg = exact(body.mass_kg());
  const scene::Control* const control = body.control();
  if (control == nullptr) return;
  if (control->stiffness() > 0) object.control.emplace_back("spring");
  if (control->friction() > 0) object.control.emplace_back("friction");
  if (control->detent_pitch() > 0) object.control.emplace_back("detents");
  if (control->curve() != nullptr && control->curve()->size() > 0) object.control.emplace_back("curve");
  if (control->has_switch()) object.control.emplace_back("switch");
}

bool is_any(const scene::Vec3& v) { return v.x() != 0 || v.y() != 0 || v.z() != 0; }

void add_force_field(const scene::ForceField& field, SceneTreeObject& object) {
  if (is_any(field.constant_n())) object.effects.emplace_back("constant");
  if (is_any(field.stiffness_n_per_m())) object.effects.emplace_back("spring");
  if (is_any(field.damping_n_s_per_m())) object.effects.emplace_back("damping");
  if (is_any(field.curl_n_s_per_m())) object.effects.emplace_back("curl");
  if (field.mass_kg() > 0) object.effects.emplace_back("mass");
  if (field.trial() > 0) object.effects.push_back("in trial " + std::to_string(field.trial()));
}

void add_material(const scene::Material& material, SceneTreeObject& object) {
  object.stiffness_N_m = exact(material.stiffness_n_per_m());
  object.damping_N_s_m = exact(material.damping_n_s_per_m());
  object.static_friction = exact(material.static_friction());
  object.dynamic_friction = exact(material.dynamic_friction());
}

}  // namespace

std::vector<SceneTreeObject> scene_tree(const CompiledScene& compiled) {
  std::vector<SceneTreeObject> tree;
  const std::vector<ObjectRegion> regions = object_regions(compiled.image);
  for (const scene::Object* source : *scene::GetScene(compiled.image.data())->objects()) {
    const SceneReport::Object& report = compiled.report.objects.at(tree.size());
    const ObjectRegion& region = regions.at(tree.size());
    SceneTreeObject& object = tree.emplace_back();
    object.name = report.name;
    object.shape = report.shape;
    object.triangles = report.mesh.triangles;
    object.bytes = report.mesh.bytes;
    if (const scene::PotentialField* field = source->shape_as_PotentialField(); field != nullptr)
      object.bytes = bytes_of(field->coefficients());
    const Eigen::Vector3d size_m = region.hi_m - region.lo_m;
    object.size_m = {size_m.x(), size_m.y(), size_m.z()};
    const bool is_plane = source->shape_type() == scene::Shape::Plane;
    const Eigen::Vector3d position_m =
        region.origin_m +
        (is_plane ? Eigen::Vector3d(region.hi_m.z() * region.rotation.col(2)) : Eigen::Vector3d::Zero());
    object.position_m = {position_m.x(), position_m.y(), position_m.z()};
    if (const scene::ForceField* field = source->shape_as_ForceField(); field != nullptr)
      add_force_field(*field, object);
    else
      add_material(*source->material(), object);
    if (source->surface() != nullptr) add_surface(*source->surface(), object);
    if (source->body() != nullptr) add_body(*source->body(), object);
  }
  return tree;
}

}  // namespace thimble::host
