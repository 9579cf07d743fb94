// The operations of a volume: an object without a surface that a god object rests on, but with a force for
// every place inside (paper, sections 4 to 6). Each kind is one file in this folder with a VolumeOps; its row
// is in control/scene/shape_table.h.
//
// All coordinates are in the object's own frame, in metres. Nothing here allocates or fails.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contact/damping.h"
#include "control/contact/friction.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "control/scene/image_verdict.h"
#include "control/scene/limits.h"
#include "control/scene/pauses.h"
#include "control/scene/shape_table.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The force of one volume on one tip.
struct VolumeTouch {
  Vec3 force_N = Vec3::Zero();
  Vec3 proxy_m = Vec3::Zero();  // the anchor of a spring with the material's stiffness and this force
  std::uint8_t contacts = 0;    // 0: no force
};

// The state that a volume keeps from tick to tick: plain data of fixed size, zero at the start. Each kind
// uses its own members. SharedState is common to all arms.
inline constexpr std::size_t kMaxHoles = 8;  // of one needle track; beyond that the oldest one closes
static_assert(kMaxHoles > kMaxArms);
struct Hole {
  float x_m = 0.0F;
  float y_m = 0.0F;
  float meets_m = 0.0F;      // the depth at which the next layer begins to push
  std::uint8_t torn = 0;     // layers
  std::uint8_t needles = 0;  // inserted now
};
struct SharedState {
  std::array<Hole, kMaxHoles> holes;
  std::uint8_t hole_count = 0;
  std::uint8_t oldest_hole = 0;
};
// Of one arm; forgotten when its tip leaves the bounds.
struct ArmState {
  bool seen = false;    // in a tick before
  bool inside = false;  // needle: below the skin; tissue: pressed
  bool barred = false;  // tissue: the tip came from the side, so it does not press
  std::uint8_t hole = 0;
  Vec3 grip_m = Vec3::Zero();    // the track and the stiction point of the shaft or the finger
  Vec3 middle_m = Vec3::Zero();  // of the dimple
  float depth_m = 0.0F;          // needle: of the tip; tissue: of the dimple
  float crept_m = 0.0F;          // tissue
  Friction friction;
};

struct VolumeBounds {
  Vec3 lo_m;
  Vec3 hi_m;
};

struct VolumeOps {
  // In the background, once: whether the numbers in the image are allowed.
  ImageVerdict (*check)(const scene::Object& object, Pauses& pauses) noexcept;
  // A box that holds every place where a tip has a force or a state. May be infinite.
  VolumeBounds (*bounds)(const scene::Object& object) noexcept;
  // One period of one tip within the bounds.
  VolumeTouch (*tick)(const scene::Object& object, const Material& material, const Tip& tip, float period_s,
                      SharedState& shared, ArmState& own) noexcept;
};

// The anchor of a spring with this stiffness and force; below 1 N/m the spring is taken as 1 N/m.
inline Vec3 spring_anchor(const Vec3& tip_m, const Vec3& force_N, float stiffness_N_m) {
  constexpr float kSoft_N_m = 1.0F;
  return tip_m + force_N / std::max(stiffness_N_m, kSoft_N_m);
}

// A push along the unit vector `normal` with damping along it (paper, section 3.4).
inline Vec3 damped_push(float push_N, const Vec3& normal, const Vec3& velocity_m_s, float damping_N_s_m) {
  return (push_N + damping_force_N(push_N, damping_N_s_m, velocity_m_s.dot(normal))) * normal;
}

}  // namespace thimble::control
