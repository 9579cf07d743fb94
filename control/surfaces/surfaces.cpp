#include "control/surfaces/surfaces.h"

#include <algorithm>
#include <array>

#include "control/surfaces/chart.h"
#include "control/surfaces/spline.h"
#include "control/surfaces/surface_view.h"

namespace thimble::control {
namespace {

// One contact in its object's frame. It has the shape's own normal, not the shaded one, because charts are
// based on the shape.
SurfacePoint place_of(const PlacedObject& object, const GodObject& rest, const Vec3& tip_m,
                      const Constraint& constraint, bool alone) noexcept {
  SurfacePoint place{object.to_local(rest.position_m), object.turn_back(constraint.normal),
                     constraint.lambda_m};
  if (alone) {
    std::array<Vec3, 3> normals;
    object.ops->normals(object.shape, rest.contacts[0].feature, place.at_m, normals);
    place.normal = normals[0];
    place.depth_m = std::max(place.normal.dot(place.at_m - object.to_local(tip_m)), 0.0F);
  }
  return place;
}

// K and B at the place; returns grad K with respect to the tip, in the object's frame.
Vec3 apply_map(const StiffnessMapView& map, const PlacedObject& object, const SurfacePoint& place,
               Material& material) noexcept {
  const Vec3 cells = map.cells_per_m * (place.at_m - map.origin_m);
  const SplineWindow u = spline_window(cells.dot(map.u), map.columns, Beyond::kClamped);
  const SplineWindow v = spline_window(cells.dot(map.v), map.rows, Beyond::kClamped);
  const SplineSample k = spline_sample(map.stiffness_N_m, map.columns, u, v);
  material.stiffness_N_m = k.value;
  if (map.damping_N_s_m != nullptr)
    material.damping_N_s_m = spline_sample(map.damping_N_s_m, map.columns, u, v).value;
  return gradient_at_tip(object, place, map.cells_per_m * (k.du * map.u + k.dv * map.v));
}

struct Relief {
  float height_m;
  Vec3 gradient;  // with respect to the tip, in the object's frame
};

Relief relief_at(const TextureView& texture, const PlacedObject& object, const SurfacePoint& place) noexcept {
  const Chart at = chart(object, place);
  const SplineWindow u = spline_window(texture.columns_per_m * at.u_m, texture.columns, Beyond::kPeriodic);
  const SplineWindow v = spline_window(texture.rows_per_m * at.v_m, texture.rows, Beyond::kPeriodic);
  const SplineSample h = spline_sample(texture.height_m, texture.columns, u, v);
  return {h.value, texture.columns_per_m * h.du * at.du + texture.rows_per_m * h.dv * at.dv};
}

// Whether the surface has no edge, so that there is one chart and the place moves continuously with the tip.
bool is_smooth(const PlacedObject& object, bool textured) noexcept {
  return object.ops->smooth && (!textured || object.row->texturing == Texturing::kTextured);
}

void apply(const PlacedObject& object, const SurfaceView& surface, const SurfacePoint& place, bool alone,
           Constraint& held, SurfaceTouch& touch) noexcept {
  held.material.static_friction += surface.brake_friction;
  held.material.dynamic_friction += surface.brake_friction;
  const TextureView& texture = surface.texture;
  const StiffnessMapView& map = surface.map;
  if (texture.height_m == nullptr && map.stiffness_N_m == nullptr) return;

  Vec3 stiffness_gradient = Vec3::Zero();
  if (map.stiffness_N_m != nullptr) {
    stiffness_gradient = object.turn(apply_map(map, object, place, held.material));
    if (!map.conservative) stiffness_gradient.setZero();
    // Friction's own spring changes with K too.
    if (!map.conservative || held.material.static_friction > 0.0F) touch.potential = false;
  }
  float pressed_m = held.lambda_m;
  if (texture.height_m != nullptr) {
    const Relief relief = relief_at(texture, object, place);
    const Vec3 gradient = object.turn(relief.gradient);
    const Vec3 tilted = held.normal - gradient;
    const float tilted_length = tilted.norm();  // at least about 1: the gradient lies along the surface
    switch (texture.kind) {
      case scene::TextureKind::Height:
        pressed_m = std::clamp(held.lambda_m + relief.height_m, 0.0F, held.lambda_m);
        touch.sunk_m += (held.lambda_m - pressed_m) * held.normal;
        held.normal = tilted / tilted_length;
        held.lambda_m = pressed_m * tilted_length;
        break;
      case scene::TextureKind::Normal:
        held.normal = tilted / tilted_length;
        touch.potential = false;
        break;
      case scene::TextureKind::Lateral:
        touch.along_N -= held.material.stiffness_N_m * held.lambda_m * gradient;
        touch.potential = false;
        break;
    }
  }
  touch.along_N -= 0.5F * pressed_m * pressed_m * stiffness_gradient;
  touch.potential = touch.potential && alone && is_smooth(object, texture.height_m != nullptr);
}

}  // namespace

SurfaceView view_surface(const scene::Surface& surface) noexcept {
  SurfaceView view;
  if (const scene::Click* click = surface.click(); click != nullptr)
    view.click = {click->amplitude_n(), click->frequency_hz(), click->decay_per_s()};
  view.brake_friction = surface.brake_friction();
  if (const scene::Texture* t = surface.texture(); t != nullptr) {
    view.texture = {t->height_m()->data(),
                    t->kind(),
                    t->columns(),
                    t->rows(),
                    static_cast<float>(t->columns()) / t->tile_u_m(),
                    static_cast<float>(t->rows()) / t->tile_v_m()};
  }
  if (const scene::StiffnessMap* m = surface.stiffness_map(); m != nullptr) {
    view.map = {m->stiffness_n_per_m()->data(),
                m->damping_n_s_per_m() != nullptr ? m->damping_n_s_per_m()->data() : nullptr,
                m->columns(),
                m->rows(),
                1.0F / m->cell_m(),
                to_vec(*m->origin_m()),
                to_vec(*m->u()),
                to_vec(*m->v()),
                m->conservative()};
  }
  return view;
}

SurfaceTouch apply_surfaces(const World& world, const GodObject& rest, const Vec3& tip_m,
                            Constraints& held) noexcept {
  SurfaceTouch touch;
  const bool alone = held.count == 1 && rest.count == 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < held.count; ++i) {
    Constraint constraint = held.list[i];
    const PlacedObject& object = world.objects[constraint.object];
    if (object.surfaced) {
      const SurfacePoint place = place_of(object, rest, tip_m, constraint, alone);
      apply(object, world.surfaces[constraint.object], place, alone, constraint, touch);
    }
    if (constraint.lambda_m > 0.0F) held.list[kept++] = constraint;
  }
  held.count = kept;
  return touch;
}

}  // namespace thimble::control
