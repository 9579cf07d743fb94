#include "control/surfaces/surfaces.h"

#include <algorithm>
#include <array>

#include "control/scene/blend.h"
#include "control/surfaces/chart.h"
#include "control/surfaces/spline.h"
#include "control/surfaces/surface_view.h"

namespace thimble::control {
namespace {

// One contact in its object's frame. Of a solid that is not shaded it has the shape's own normal.
SurfacePoint place_of(const PlacedObject& object, const GodObject& rest, const Vec3& tip_m,
                      const Constraint& constraint, bool alone) noexcept {
  const float radius_m = constraint.to_place_m.norm();  // of the tip
  SurfacePoint place{object.to_local(rest.position_m + constraint.to_place_m),
                     object.turn_back(constraint.normal), constraint.lambda_m - radius_m,
                     rest.contacts[constraint.contact].feature};
  if (alone && !object.shaded) {
    std::array<Vec3, 3> normals;
    object.ops->normals(object.shape, place.feature, place.at_m, normals);
    place.normal = normals[0];
    place.depth_m =
        std::max(place.normal.dot(object.to_local(rest.position_m) - object.to_local(tip_m)), 0.0F) -
        radius_m;
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

// The height at a place in metres along u and v, and its slopes.
SplineSample sample(const TextureView& texture, float u_m, float v_m) noexcept {
  const SplineWindow u = spline_window(texture.columns_per_m * u_m, texture.columns, Beyond::kPeriodic);
  const SplineWindow v = spline_window(texture.rows_per_m * v_m, texture.rows, Beyond::kPeriodic);
  SplineSample h = spline_sample(texture.height_m, texture.columns, u, v);
  h.du *= texture.columns_per_m;
  h.dv *= texture.rows_per_m;
  return h;
}

// h = sum w_i h_i over the axes i; its gradient has that of the weights.
Relief blended_relief(const TextureView& texture, const Vec3& at_m, const Blend& blend) noexcept {
  Relief relief{0.0F, Vec3::Zero()};
  for (int axis = 0; axis < 3; ++axis) {
    const float weight = blend.weight[axis];
    if (weight == 0.0F) continue;  // then its slope is 0 too
    const int u = axis == 0 ? 1 : 0;
    const int v = axis == 2 ? 1 : 2;
    const SplineSample h = sample(texture, at_m[u], at_m[v]);
    relief.height_m += weight * h.value;
    relief.gradient += h.value * blend.slope[static_cast<std::size_t>(axis)];
    relief.gradient[u] += weight * h.du;
    relief.gradient[v] += weight * h.dv;
  }
  return relief;
}

Relief relief_at(const TextureView& texture, const PlacedObject& object, const SurfacePoint& place) noexcept {
  if (Blend blend; object.ops->blend != nullptr && object.ops->blend(object.shape, place, blend)) {
    const Relief relief = blended_relief(texture, place.at_m, blend);
    return {relief.height_m, gradient_at_tip(object, place, relief.gradient)};
  }
  const Chart at = chart(object, place);
  const SplineSample h = sample(texture, at.u_m, at.v_m);
  const Vec3 gradient = h.du * at.du + h.dv * at.dv;
  if (!at.in_space) return {h.value, gradient};
  return {at.strength * h.value,
          gradient_at_tip(object, place, at.strength * gradient + h.value * at.strength_slope)};
}

// How much of the depth in its object a constraint is. Where several planes of one object hold the tip, as between two facets, its
// relief is below them once.
float share_of_depth(const Constraints& held, const Constraint& constraint) noexcept {
  if (held.count == 1) return 1.0F;
  Vec3 pull = Vec3::Zero();
  std::size_t planes = 0;
  for (std::size_t i = 0; i < held.count; ++i) {
    if (held.list[i].object != constraint.object) continue;
    pull += held.list[i].lambda_m * held.list[i].normal;
    ++planes;
  }
  const float depth_m = pull.norm();
  return planes == 1 || !(depth_m > 0.0F) ? 1.0F : constraint.lambda_m / depth_m;
}

void apply(const PlacedObject& object, const SurfaceView& surface, const SurfacePoint& place, bool alone,
           float share, Constraint& held, SurfaceTouch& touch) noexcept {
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
        pressed_m = std::clamp(held.lambda_m + share * relief.height_m, 0.0F, held.lambda_m);
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
  touch.potential = touch.potential && alone && object.ops->smooth;
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
  const Constraints given = held;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < given.count; ++i) {
    Constraint constraint = given.list[i];
    const PlacedObject& object = world.objects[constraint.object];
    if (object.surfaced) {
      const SurfacePoint place = place_of(object, rest, tip_m, constraint, alone);
      apply(object, world.surfaces[constraint.object], place, alone, share_of_depth(given, constraint),
            constraint, touch);
    }
    if (constraint.lambda_m > 0.0F) held.list[kept++] = constraint;
  }
  held.count = kept;
  return touch;
}

}  // namespace thimble::control
