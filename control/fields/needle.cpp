// A needle in layers of tissue (paper, section 6), after Okamura, Simone and O'Leary 2004: a layer pushes
// back as a spring until it tears; then the shaft has friction in it.
//
// Energy: a tear loses all energy of the layer's spring. The next layer begins to push at the place of the
// tip then, or at its own top, so no energy is stored that the hand did not supply. The springs of shaft and
// track start at a point that moves only towards the tip.
#include <algorithm>
#include <cmath>
#include <limits>

#include "control/fields/volume.h"
#include "control/scene/check.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

// A needle that is inserted within this distance of a hole uses that hole.
constexpr float kHoleReach_m = 2.0e-3F;

ImageVerdict needle_check(const scene::Object& object, Pauses& /*pauses*/) noexcept {
  return check_needle(*object.shape_as_Needle());
}

[[gnu::cold]] VolumeBounds needle_bounds(const scene::Object&) noexcept {
  constexpr float kEverywhere = std::numeric_limits<float>::infinity();
  return {Vec3::Constant(-kEverywhere), Vec3::Constant(kEverywhere)};
}

// The hole at this place of the skin: the nearest one within kHoleReach_m, else a new one. When there are
// kMaxHoles already, the new one replaces the oldest hole without a needle.
std::uint8_t hole_at(SharedState& shared, const Vec3& at) {
  std::size_t found = kMaxHoles;
  float nearest2 = kHoleReach_m * kHoleReach_m;
  for (std::size_t i = 0; i < shared.hole_count; ++i) {
    const Hole& hole = shared.holes[i];
    const float distance2 =
        (at.x() - hole.x_m) * (at.x() - hole.x_m) + (at.y() - hole.y_m) * (at.y() - hole.y_m);
    if (distance2 > nearest2) continue;
    nearest2 = distance2;
    found = i;
  }
  if (found < kMaxHoles) return static_cast<std::uint8_t>(found);
  if (shared.hole_count < kMaxHoles) {
    found = shared.hole_count++;
  } else {
    for (std::size_t i = 0; i < kMaxHoles; ++i) {  // fewer arms than holes: one of them is empty
      found = shared.oldest_hole;
      shared.oldest_hole = static_cast<std::uint8_t>((found + 1) % kMaxHoles);
      if (shared.holes[found].needles == 0) break;
    }
  }
  shared.holes[found] = {.x_m = at.x(), .y_m = at.y()};
  return static_cast<std::uint8_t>(found);
}

struct LayerForces {
  float push_N = 0.0F;  // of the layer that is not torn yet
  float friction_N = 0.0F;
  float viscosity_N_s_m = 0.0F;
};

// Tears the layers that the tip tears at this depth, and sums up the forces of the layers.
LayerForces cut_layers(const scene::Needle& needle, Hole& hole, float depth_m) {
  LayerForces forces;
  float top_m = 0.0F;
  const std::uint32_t count = needle.layers()->size();
  for (std::uint32_t i = 0; i < count && i <= hole.torn; ++i) {
    const scene::Layer& layer = *needle.layers()->Get(i);
    const float bottom_m = top_m + layer.thickness_m();
    if (i == hole.torn) {
      const float stretch_m = depth_m - hole.meets_m;
      if (stretch_m <= 0.0F) break;
      const float push_N = layer.stiffness_n_per_m() * stretch_m;
      if (push_N < layer.tear_n()) {
        forces.push_N = push_N;
        break;
      }
      const float gave_m = layer.tear_n() > 0.0F ? layer.tear_n() / layer.stiffness_n_per_m() : 0.0F;
      hole.meets_m = std::max(bottom_m, hole.meets_m + gave_m);
      ++hole.torn;
    }
    const float shaft_m = std::clamp(depth_m - top_m, 0.0F, layer.thickness_m());
    forces.friction_N += layer.friction_n() * (shaft_m / layer.thickness_m());
    forces.viscosity_N_s_m += layer.viscosity_n_s_per_m2() * shaft_m;
    top_m = bottom_m;
  }
  return forces;
}

VolumeTouch needle_tick(const scene::Object& object, const Material& material, const Tip& tip, float,
                        SharedState& shared, ArmState& own) noexcept {
  const Vec3& x = tip.position_m;
  const float depth_m = -x.z();
  const bool first = !own.seen;
  own.seen = true;
  if (depth_m <= 0.0F) {
    if (own.inside) --shared.holes[own.hole].needles;
    own.inside = false;
    own.depth_m = 0.0F;
    return {};
  }
  if (!own.inside) {
    own.inside = true;
    own.hole = hole_at(shared, x);
    own.grip_m = x;
    ++shared.holes[own.hole].needles;
    // A tip that starts inside has done no work yet.
    if (first) shared.holes[own.hole].meets_m = std::max(shared.holes[own.hole].meets_m, depth_m);
  }
  own.depth_m = depth_m;
  const LayerForces forces = cut_layers(*object.shape_as_Needle(), shared.holes[own.hole], depth_m);

  // The shaft sticks at the grip and drags it along at the Coulomb force. Friction depends on position only,
  // so it does not creep.
  const float holds_m = forces.friction_N / material.stiffness_N_m;
  own.grip_m.z() = x.z() + std::clamp(own.grip_m.z() - x.z(), -holds_m, holds_m);
  const Vec3 sideways(tip.velocity_m_s.x(), tip.velocity_m_s.y(), 0.0F);
  VolumeTouch touch;
  touch.force_N = material.stiffness_N_m * (own.grip_m - x) - material.damping_N_s_m * sideways +
                  damped_push(forces.push_N, Vec3::UnitZ(), tip.velocity_m_s, material.damping_N_s_m);
  touch.force_N.z() -= forces.viscosity_N_s_m * tip.velocity_m_s.z();
  touch.proxy_m = spring_anchor(x, touch.force_N, material.stiffness_N_m);
  touch.contacts = 1;
  return touch;
}

}  // namespace

const VolumeOps kNeedleVolume = {needle_check, needle_bounds, needle_tick};

}  // namespace thimble::control
