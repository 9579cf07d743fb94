// The bodies as the contact solver sees them.
#pragma once

#include <cstdint>

#include "control/scene/limits.h"
#include "kinematics/vector.h"

namespace thimble::control {

// A thousandth of the response of the heaviest body. Below that, neither body can move.
inline constexpr float kNoResponse = 1.0e-3F / kMaxMass_kg;

// One body as the solver sees it. An impulse J at p changes v by inverse_mass J and w by inverse_inertia (p -
// centre) x J.
struct SolverBody {
  std::uint8_t object = 0;
  Vec3 centre_m = Vec3::Zero();
  Mat3 inverse_mass = Mat3::Zero();
  Mat3 inverse_inertia = Mat3::Zero();
  Vec3 velocity_m_s = Vec3::Zero();  // of the centre; as input, with the forces of this tick applied
  Vec3 spin_rad_s = Vec3::Zero();
  // The impulse of this tick's forces in the directions that the body cannot move in.
  Vec3 constrained_N_s = Vec3::Zero();
  Vec3 gained_m_s = Vec3::Zero();  // of velocity_m_s: by the forces of this tick
  Vec3 begin_m_s = Vec3::Zero();   // velocity_m_s and spin_rad_s before the contacts
  Vec3 begin_rad_s = Vec3::Zero();
  float restitution = 0.0F;
  bool asleep = false;  // takes no part
  // Output: changes of the pose that remove residual penetration, without adding velocity.
  Vec3 correction_m = Vec3::Zero();
  Vec3 correction_rad = Vec3::Zero();
};

}  // namespace thimble::control
