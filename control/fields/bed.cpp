// Bodies on soft tissue. The tissue pushes along its normal at the points of a body that are below the skin and within
// the half widths: F = K_relaxed d + C d', C = (K - K_relaxed) K_relaxed / K * recovery, which is how the
// three-parameter solid of tissue.cpp answers slow motion. It keeps no state: a body leaves no dimple. The points of a
// body share the stiffness. Friction is viscous up to the coefficient times F.
#include <algorithm>
#include <cmath>

#include "control/bodies/bodies.h"
#include "control/bodies/collide.h"
#include "control/fields/fields.h"
#include "control/scene/shape_table.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

// How many points of a body carry it when it stands upright.
float bearing_points(CollisionForm form) {
  constexpr float kOfFace = 4.0F;
  return form == CollisionForm::kBall ? 1.0F : form == CollisionForm::kCapsule ? 2.0F : kOfFace;
}

// A half-space in the place of the skin.
PlacedObject skin(const Mat3& rotation, const Vec3& position_m) {
  PlacedObject plane;
  plane.row = &shape_row(scene::Shape::Plane);
  plane.ops = plane.row->solid;
  plane.shape.vector = Vec3::UnitZ();
  plane.rotation = rotation;
  plane.turned = true;
  plane.position_m = position_m;
  return plane;
}

}  // namespace

void Fields::press(const World& world, float period_s, Bodies& bodies) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Placed& placed = placed_[i];
    if (placed.ops != &kTissueVolume) continue;
    const scene::Tissue& tissue = *placed.source->shape_as_Tissue();
    const PlacedObject plane = skin(placed.rotation, placed.position_m);
    for (std::size_t k = 0; k < world.count; ++k) {
      if (world.objects[k].body != kNoBody)
        press_body(placed, tissue, plane, world.objects[k], period_s, bodies);
    }
  }
}

void Fields::press_body(const Placed& placed, const scene::Tissue& tissue, const PlacedObject& plane,
                        const PlacedObject& body, float period_s, Bodies& bodies) noexcept {
  Manifold manifold;
  collide_with_plane(body, plane, manifold);
  const float points = bearing_points(body.row->collision->form);
  const float stiffness_N_m = tissue.relaxed_stiffness_n_per_m();
  const float creep_N_s_m =
      (1.0F - stiffness_N_m / placed.material.stiffness_N_m) * stiffness_N_m * tissue.recovery_s();
  // Explicit damping is stable up to m / T, also where it acts on an arm.
  constexpr float kStable = 0.15F;
  const float most_N_s_m = kStable * body.source->body()->mass_kg() / period_s;
  const float damping_N_s_m = std::min(creep_N_s_m + placed.material.damping_N_s_m, most_N_s_m);
  for (std::size_t i = 0; i < manifold.count; ++i) {
    const ContactPoint& point = manifold.points[i];
    const Vec3 local = placed.rotation.transpose() * (point.point_m - placed.position_m);
    if (std::abs(local.x()) > tissue.half_x_m() || std::abs(local.y()) > tissue.half_y_m()) continue;
    const Vec3 velocity = bodies.velocity_at(body.body, point.point_m);
    const float rising = velocity.dot(point.normal);
    const float push_N = std::max(stiffness_N_m * point.depth_m - damping_N_s_m * rising, 0.0F) / points;
    const Vec3 along = velocity - rising * point.normal;
    const float speed = along.norm();
    const float drag_N = std::min(placed.material.dynamic_friction * push_N, most_N_s_m / points * speed);
    Vec3 force_N = push_N * point.normal;
    if (speed > 0.0F) force_N -= (drag_N / speed) * along;
    bodies.push(body.body, point.point_m, force_N);
  }
}

}  // namespace thimble::control
