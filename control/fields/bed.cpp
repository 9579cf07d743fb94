// Bodies on soft tissue. The tissue pushes along its normal at the points of a body that are below the skin and within
// the half widths: F = K_relaxed d + C d', C = (K - K_relaxed) K_relaxed / K * recovery, which is how the
// three-parameter solid of tissue.cpp answers slow motion. It keeps no state: a body leaves no dimple. The points of a
// body share the stiffness. Friction is viscous up to the coefficient times F.
#include <algorithm>
#include <cmath>

#include "control/bodies/bodies.h"
#include "control/bodies/pair_collision.h"
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

// The box about an object, in the frame of a tissue, reaches below its skin.
bool reaches(const PlacedObject& body, const Mat3& rotation, const Vec3& position_m,
             const scene::Tissue& tissue) {
  const Vec3 half = 0.5F * (body.hi_m - body.lo_m);
  const Vec3 middle = rotation.transpose() * (body.lo_m + half - position_m);
  const Vec3 reach = rotation.transpose().cwiseAbs() * half;
  return middle.z() <= reach.z() && std::abs(middle.x()) <= tissue.half_x_m() + reach.x() &&
         std::abs(middle.y()) <= tissue.half_y_m() + reach.y();
}

}  // namespace

bool Fields::press(const World& world, float period_s, Bodies& bodies, Work& work) noexcept {
  if (!bodies.wait()) {
    press_.volume = press_.object = press_.piece = press_.corner = 0;
    press_.begun = false;
  }
  for (; press_.volume < count_; ++press_.volume, press_.object = 0) {
    const Placed& placed = placed_[press_.volume];
    if (placed.ops != &kTissueVolume) continue;
    const PlacedObject plane = skin(placed.rotation, placed.position_m);
    while (press_.object < world.count) {
      const PlacedObject& body = world.objects[press_.object];
      const bool moves = body.body != kNoBody && (bodies.asleep() & of_body(body.body)) == 0;
      if (!moves || press_next(placed, plane, body, period_s, bodies, work)) ++press_.object;
      if (moves && work.left() == 0) return false;
    }
  }
  return true;
}

// True: it has pushed the body, or does not touch it.
bool Fields::press_next(const Placed& placed, const PlacedObject& plane, const PlacedObject& body,
                        float period_s, Bodies& bodies, Work& work) noexcept {
  constexpr std::uint32_t kPointWork = 2;
  work.at(static_cast<std::uint8_t>(press_.object));
  if (!press_.begun) {
    work.charge(1);
    if (!reaches(body, placed.rotation, placed.position_m, *placed.source->shape_as_Tissue())) return true;
    press_.begun = true;
    press_.manifold.count = 0;
  }
  press_.manifold.work = &work;
  if (!meet_plane(body, plane, press_.piece, press_.corner, press_.manifold)) return false;
  press_.begun = false;
  work.charge(kPointWork * static_cast<std::uint32_t>(press_.manifold.count));
  push_body(placed, press_.manifold, body, period_s, bodies);
  return true;
}

void Fields::push_body(const Placed& placed, const Manifold& manifold, const PlacedObject& body,
                       float period_s, Bodies& bodies) noexcept {
  const scene::Tissue& tissue = *placed.source->shape_as_Tissue();
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
    const Vec3 velocity = bodies.speed_at(body.body, point.point_m);
    const float rising = velocity.dot(point.normal);
    const float push_N = std::max(stiffness_N_m * point.depth_m - damping_N_s_m * rising, 0.0F) / points;
    const Vec3 along = velocity - rising * point.normal;
    const float speed = along.norm();
    const float drag_N = std::min(placed.material.dynamic_friction * push_N, most_N_s_m / points * speed);
    Vec3 force_N = push_N * point.normal;
    if (speed > 0.0F) force_N -= (drag_N / speed) * along;
    bodies.press_on(body.body, point.point_m, force_N);
  }
}

}  // namespace thimble::control
