// Contacts between bodies, and between bodies and fixed objects: sequential impulses with warm starting
// (Catto 2005).
//
// Stages of one tick: collect_contacts and prepare, warm_start, solve (friction and normal impulses), update
// of the sliding states, correct_positions, store_impulses.
//
// A normal impulse is never negative. A contact that is still open may close by its gap in this tick and no
// more, so no body enters another by its speed. A contact that closes faster than kBounce_m_s bounces with
// the larger restitution of the two bodies. The friction impulse lies in a cone: the static coefficient until
// the contact slips, the dynamic one while it slides. Each coefficient is the geometric mean of the two
// materials'. Residual penetration is removed by position correction, so it adds no kinetic energy.
//
// Bounds: kMaxBodyContacts points, kSolverIterations iterations, kMaxObjects * kMaxBodies pairs. A contact point
// beyond the bound is ignored and counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/collide.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "kinematics/vector.h"

namespace thimble::control {

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
  float restitution = 0.0F;
  // Output: the position correction that removes penetration.
  Vec3 correction_m = Vec3::Zero();
  Vec3 correction_rad = Vec3::Zero();
};

class ContactSolver {
 public:
  // Forgets the contacts of the last tick.
  void reset() noexcept;

  // Collects the contacts of `bodies`, changes their velocities and writes their position corrections.
  void solve(const World& world, std::span<SolverBody> bodies, float period_s,
             RenderCounters& counters) noexcept;

  [[nodiscard]] std::size_t contacts() const noexcept { return count_; }

 private:
  // One direction of a contact: relative velocity = direction . (va - vb) + arm_a . wa - arm_b . wb.
  struct Row {
    Vec3 direction;
    Vec3 arm_a;
    Vec3 arm_b;
    Vec3 linear_a;  // velocity change of each body for a unit of impulse
    Vec3 angular_a;
    Vec3 linear_b;
    Vec3 angular_b;
    float mass = 0.0F;  // effective mass; 0: neither body can move in this direction
    float impulse = 0.0F;
  };
  struct Contact {
    std::uint8_t object_a = 0;
    std::uint8_t object_b = 0;
    std::uint8_t a = 0;  // indices of the bodies; kNoBody: a fixed object
    std::uint8_t b = 0;
    bool sliding = false;
    bool bounces = false;
    Vec3 point_m;
    float depth_m = 0.0F;
    float target_m_s = 0.0F;
    float static_friction = 0.0F;
    float dynamic_friction = 0.0F;
    Row normal;
    std::array<Row, 2> tangent;
  };
  // The impulses of a contact point, for the warm start in the next tick.
  struct StoredImpulse {
    std::uint8_t object_a = 0;
    std::uint8_t object_b = 0;
    bool sliding = false;
    Vec3 point_m;
    float normal_N_s = 0.0F;
    Vec3 tangent_N_s;
  };

  void collect_contacts(const World& world, std::span<SolverBody> bodies, float period_s,
                        RenderCounters& counters) noexcept;
  void collect_pair(const World& world, std::span<SolverBody> bodies, std::size_t a, std::size_t object_b,
                    std::uint8_t b, float period_s, RenderCounters& counters) noexcept;
  void prepare(const World& world, std::span<SolverBody> bodies, const Contact& contact, const Vec3& normal,
               std::size_t in_manifold, float period_s) noexcept;
  void warm_start(std::span<SolverBody> bodies, Contact& contact) const noexcept;
  void correct_positions(std::span<SolverBody> bodies) noexcept;
  void store_impulses() noexcept;

  static Row row(std::span<const SolverBody> bodies, const Contact& contact, const Vec3& direction) noexcept;
  static float speed(std::span<const SolverBody> bodies, const Contact& contact, const Row& row) noexcept;
  static void apply_impulse(std::span<SolverBody> bodies, const Contact& contact, const Row& row,
                            float impulse) noexcept;
  static void solve_friction(std::span<SolverBody> bodies, Contact& contact) noexcept;

  std::array<Contact, kMaxBodyContacts> contacts_;
  std::array<StoredImpulse, kMaxBodyContacts> stored_;
  std::size_t count_ = 0;
  std::size_t stored_count_ = 0;
};

}  // namespace thimble::control
