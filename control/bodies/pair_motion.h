// What the impulses of a contact patch do to its two bodies: the contact solver asks for each patch. Apart from SolverBody, because a file
// that includes these functions takes half a second longer to compile.
#pragma once

#include <cstddef>
#include <span>

#include "control/bodies/contact_patches.h"
#include "control/bodies/solver_body.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

// r.normal is set. `like`: a row of the patch, or null.
inline void set_row(std::span<const SolverBody> bodies, const Patch& patch, const Vec3& point_m,
                    const NormalRow* like, NormalRow& r) {
  const bool alike = like != nullptr && like->normal == r.normal;
  const SolverBody& a = bodies[patch.a];
  r.arm_a = (point_m - a.centre_m).cross(r.normal);
  r.linear_a = alike ? like->linear_a : Vec3(a.inverse_mass * r.normal);
  r.angular_a = a.inverse_inertia * r.arm_a;
  float response = r.normal.dot(r.linear_a) + r.arm_a.dot(r.angular_a);
  if (patch.b != kNoBody) {
    const SolverBody& b = bodies[patch.b];
    r.arm_b = (point_m - b.centre_m).cross(r.normal);
    r.linear_b = alike ? like->linear_b : Vec3(b.inverse_mass * r.normal);
    r.angular_b = b.inverse_inertia * r.arm_b;
    response += r.normal.dot(r.linear_b) + r.arm_b.dot(r.angular_b);
  }
  r.mass = response > kNoResponse ? 1.0F / response : 0.0F;
}

// The motion of the two bodies of a patch, while its normal impulses change it.
class PairMotion {
 public:
  PairMotion(std::span<const SolverBody> bodies, const Patch& patch) : both_(patch.b != kNoBody) {
    of_a_ = bodies[patch.a].velocity_m_s;
    spin_of_a_ = bodies[patch.a].spin_rad_s;
    if (!both_) return;
    of_b_ = bodies[patch.b].velocity_m_s;
    spin_of_b_ = bodies[patch.b].spin_rad_s;
  }
  void store(std::span<SolverBody> bodies, const Patch& patch) const {
    bodies[patch.a].velocity_m_s = of_a_;
    bodies[patch.a].spin_rad_s = spin_of_a_;
    if (!both_) return;
    bodies[patch.b].velocity_m_s = of_b_;
    bodies[patch.b].spin_rad_s = spin_of_b_;
  }
  [[nodiscard]] float separation_speed(const NormalRow& r) const {
    const float of_a = r.normal.dot(of_a_) + r.arm_a.dot(spin_of_a_);
    return both_ ? of_a - r.normal.dot(of_b_) - r.arm_b.dot(spin_of_b_) : of_a;
  }
  void add(const NormalRow& r, float impulse) {
    of_a_ += impulse * r.linear_a;
    spin_of_a_ += impulse * r.angular_a;
    if (!both_) return;
    of_b_ -= impulse * r.linear_b;
    spin_of_b_ -= impulse * r.angular_b;
  }

 private:
  bool both_;
  Vec3 of_a_;
  Vec3 spin_of_a_;
  Vec3 of_b_ = Vec3::Zero();
  Vec3 spin_of_b_ = Vec3::Zero();
};

inline Vec3 velocity_at(const SolverBody& body, const Vec3& point_m) {
  return body.velocity_m_s + body.spin_rad_s.cross(point_m - body.centre_m);
}

// The relative velocity of a patch in its three directions of friction.
inline Vec3 slip_speed(std::span<const SolverBody> bodies, const Patch& patch) {
  Vec3 velocity = velocity_at(bodies[patch.a], patch.centre_m);
  Vec3 spin = bodies[patch.a].spin_rad_s;
  if (patch.b != kNoBody) {
    velocity -= velocity_at(bodies[patch.b], patch.centre_m);
    spin -= bodies[patch.b].spin_rad_s;
  }
  return {patch.across[0].dot(velocity), patch.across[1].dot(velocity),
          patch.radius_m * patch.normal.dot(spin)};
}

inline void apply_friction_impulse(std::span<SolverBody> bodies, const Patch& patch, const Vec3& impulse) {
  const Vec3 force = impulse[0] * patch.across[0] + impulse[1] * patch.across[1];
  const Vec3 moment = (patch.radius_m * impulse[2]) * patch.normal;
  SolverBody& a = bodies[patch.a];
  a.velocity_m_s += a.inverse_mass * force;
  a.spin_rad_s += a.inverse_inertia * ((patch.centre_m - a.centre_m).cross(force) + moment);
  if (patch.b == kNoBody) return;
  SolverBody& b = bodies[patch.b];
  b.velocity_m_s -= b.inverse_mass * force;
  b.spin_rad_s -= b.inverse_inertia * ((patch.centre_m - b.centre_m).cross(force) + moment);
}

// How a body answers to unit impulses in the three directions of friction.
inline Mat3 response_of(const SolverBody& body, const Patch& patch) {
  const Vec3 arm = patch.centre_m - body.centre_m;
  Mat3 turning;
  turning << arm.cross(patch.across[0]), arm.cross(patch.across[1]), patch.radius_m * patch.normal;
  Mat3 response = turning.transpose() * (body.inverse_inertia * turning);
  for (int i = 0; i < 2; ++i) {
    const Vec3 linear = body.inverse_mass * patch.across[static_cast<std::size_t>(i)];
    for (int j = 0; j < 2; ++j) response(i, j) += linear.dot(patch.across[static_cast<std::size_t>(j)]);
  }
  return response;
}

}  // namespace thimble::control
