// Soft tissue under a finger (the paper's DEFORM, section 6): a three-parameter solid (Zener; Fung,
// Biomechanics, 1993, section 2.11), one spring in series with a second one that a damper bridges.
//
//   F = K (d - c),   recovery c' = g (d - c) - c,   g = (K - K_relaxed) / K_relaxed,   d the tip's depth, c what has crept.
//
// Immediately F = K d; held for a long time F = K_relaxed d. After release, c is the remaining dimple; it
// recovers with the time constant `recovery`. The surface does not pull, so a tip above it has no force; if
// it presses again soon, it reaches the tissue lower down. Energy: the springs store the energy that the hand
// supplied, the damper dissipates it. c is taken at the end of the period (implicit), which dissipates
// slightly more.
#include "control/fields/tissue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/fields/volume.h"
#include "control/scene/check.h"
#include "kinematics/trig.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

ImageVerdict tissue_check(const scene::Object& object, Pauses& /*pauses*/) noexcept {
  return check_tissue(*object.shape_as_Tissue(), object.material()->stiffness_n_per_m());
}

[[gnu::cold]] VolumeBounds tissue_bounds(
    const scene::Object&) noexcept {  // a dimple recovers wherever the tip is
  constexpr float kEverywhere = std::numeric_limits<float>::infinity();
  return {Vec3::Constant(-kEverywhere), Vec3::Constant(kEverywhere)};
}

// The depth of the surface at the tip: that of its own dimple, or beside it that of the elastic surface
// around the dimple.
float surface_depth_m(const scene::Tissue& tissue, const ArmState& own, const Vec3& x) {
  if (own.inside || own.crept_m == 0.0F) return own.crept_m;
  return dimple_depth_m(own.crept_m, tissue.contact_radius_m(),
                        planar_length(x.x() - own.middle_m.x(), x.y() - own.middle_m.y()));
}

VolumeTouch tissue_tick(const scene::Object& object, const Material& material, const Tip& tip, float period_s,
                        SharedState&, ArmState& own) noexcept {
  const scene::Tissue& tissue = *object.shape_as_Tissue();
  const Vec3& x = tip.position_m;
  const float depth_m = -x.z();
  const bool over = std::abs(x.x()) <= tissue.half_x_m() && std::abs(x.y()) <= tissue.half_y_m();
  const float surface_m = over ? surface_depth_m(tissue, own, x) : 0.0F;
  // Only a tip that comes from above presses. A tip that starts inside, or enters from the side, has done no
  // work yet.
  const bool first = !own.seen;
  own.seen = true;
  if (depth_m <= surface_m) {
    own.barred = false;
  } else if (first || !over) {
    own.barred = true;
  }
  const bool pressed = over && !own.barred && depth_m > surface_m;
  if (pressed && !own.inside) {
    own.crept_m = surface_m;
    own.grip_m = x;
    own.friction.reset();
  }
  own.inside = pressed;
  const float part = period_s / tissue.recovery_s();
  if (!pressed) {
    own.crept_m /= 1.0F + part;
    own.depth_m = own.crept_m;
    return {};
  }
  constexpr float kSoftest_N_m = 1.0e-20F;  // avoids a division by zero
  const float relaxed = std::max(tissue.relaxed_stiffness_n_per_m(), kSoftest_N_m);
  const float give = (material.stiffness_N_m - relaxed) / relaxed;
  own.crept_m = (own.crept_m + part * give * depth_m) / (1.0F + part * (1.0F + give));
  own.middle_m = x;
  own.depth_m = depth_m;

  const float stretch_m = depth_m - own.crept_m;
  const float drag_m = planar_length(own.grip_m.x() - x.x(), own.grip_m.y() - x.y());
  const float held_m = own.friction.tick({material.stiffness_N_m, material.static_friction * stretch_m,
                                          material.dynamic_friction * stretch_m, material.steady},
                                         drag_m, period_s);
  if (held_m < drag_m) own.grip_m = x + (held_m / drag_m) * (own.grip_m - x);
  VolumeTouch touch;
  touch.force_N = damped_push(material.stiffness_N_m * stretch_m, Vec3::UnitZ(), tip.velocity_m_s,
                              material.damping_N_s_m);
  touch.force_N.x() = material.stiffness_N_m * (own.grip_m.x() - x.x());
  touch.force_N.y() = material.stiffness_N_m * (own.grip_m.y() - x.y());
  touch.proxy_m = spring_anchor(x, touch.force_N, material.stiffness_N_m);
  touch.contacts = 1;
  return touch;
}

}  // namespace

float dimple_depth_m(float depth_m, float radius_m, float r_m) noexcept {
  if (r_m <= radius_m) return depth_m;
  return depth_m * (2.0F / std::numbers::pi_v<float>)*kinematics::arc_sine(radius_m / r_m);
}

const VolumeOps kTissueVolume = {tissue_check, tissue_bounds, tissue_tick};

}  // namespace thimble::control
