// What every volume answers: an object with no surface for a god object to rest on, but a force for every place inside
// (paper, sections 4 to 6). A new kind is one file with a VolumeOps and one row in fields.cpp and check_volume.cpp.
//
// All coordinates are in the object's own frame, in metres. Nothing here allocates or fails.
#pragma once

#include <algorithm>
#include <cstdint>

#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "kinematics/vector.h"

namespace thimble::control {

// What one tip feels of one volume.
struct VolumeTouch {
  Vec3 force_N = Vec3::Zero();
  Vec3 proxy_m = Vec3::Zero();  // where a spring of the material's stiffness with this force would begin
  std::uint8_t contacts = 0;    // 0: nothing is felt
};

// What a volume remembers from tick to tick. Plain data of fixed size, all zero at the start; a kind uses its own members.
struct SharedState {};  // the same for all arms: what one of them did to it
struct ArmState {};     // of one arm; forgotten when its tip leaves the bounds

struct VolumeBounds {
  Vec3 lo_m;
  Vec3 hi_m;
};

struct VolumeOps {
  // A box that holds every place where a tip is felt or remembered. May be infinite.
  VolumeBounds (*bounds)(const scene::Object& object) noexcept;
  // One period of one tip within the bounds.
  VolumeTouch (*tick)(const scene::Object& object, const Material& material, const Tip& tip, float period_s,
                      SharedState& shared, ArmState& own) noexcept;
};

extern const VolumeOps kVectorFieldOps;
extern const VolumeOps kPotentialFieldOps;

// A push along the unit vector `normal`, with damping across it that never pulls (paper, section 3.4).
inline Vec3 damped_push(float push_N, const Vec3& normal, const Vec3& velocity_m_s, float damping_N_s_m) {
  return (push_N + std::max(-damping_N_s_m * velocity_m_s.dot(normal), -push_N)) * normal;
}

}  // namespace thimble::control
