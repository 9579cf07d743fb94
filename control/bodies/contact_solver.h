// Contacts among bodies, and of bodies with what stands still: sequential impulses with warm starting (Catto 2005).
//
// Normal impulses only push. A contact that is still open is held to close no farther than its gap in this tick, so nothing
// enters by its speed; one that closes faster than kBounce_m_s bounces with the larger restitution of the two. Friction is a cone:
// static until it slips, dynamic while it does, each coefficient the geometric mean of the two materials'. What has entered all
// the same is moved out by places, not by speeds, which gives no energy.
//
// Bounds: kMaxBodyContacts points, kSolverRounds rounds, kMaxObjects * kMaxBodies pairs. A point beyond is left out and counted.
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

// One body as the solver has it: how it answers to an impulse J at p: v += inverse_mass J, w += inverse_inertia (p - centre) x J.
struct Mover {
  std::uint8_t object = 0;
  Vec3 centre_m = Vec3::Zero();
  Mat3 inverse_mass = Mat3::Zero();
  Mat3 inverse_inertia = Mat3::Zero();
  Vec3 velocity_m_s = Vec3::Zero();  // of the centre; in: with this tick's forces
  Vec3 spin_rad_s = Vec3::Zero();
  Vec3 held_N_s = Vec3::Zero();  // impulse of this tick's forces in the directions that it cannot move in
  float restitution = 0.0F;
  Vec3 shift_m = Vec3::Zero();  // out: by how much to move it out of others, and turn it
  Vec3 shift_rad = Vec3::Zero();
};

class ContactSolver {
 public:
  // Forgets the contacts of the last tick.
  void reset() noexcept;

  // Finds the contacts of `movers` and changes their velocities.
  void solve(const World& world, std::span<Mover> movers, float period_s, RenderCounters& counters) noexcept;

  [[nodiscard]] std::size_t contacts() const noexcept { return count_; }

 private:
  // One direction of a contact: relative velocity = way . (va - vb) + arm_a . wa - arm_b . wb.
  struct Row {
    Vec3 way;
    Vec3 arm_a;
    Vec3 arm_b;
    Vec3 linear_a;  // what a unit of impulse does to each
    Vec3 angular_a;
    Vec3 linear_b;
    Vec3 angular_b;
    float mass = 0.0F;  // 0: nothing can move along it
    float impulse = 0.0F;
  };
  struct Contact {
    std::uint8_t object_a = 0;
    std::uint8_t object_b = 0;
    std::uint8_t a = 0;  // movers; kNoBody: stands still
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
  // What a contact leaves to the next tick.
  struct Kept {
    std::uint8_t object_a = 0;
    std::uint8_t object_b = 0;
    bool sliding = false;
    Vec3 point_m;
    float normal_N_s = 0.0F;
    Vec3 tangent_N_s;
  };

  void find(const World& world, std::span<Mover> movers, float period_s, RenderCounters& counters) noexcept;
  void meet(const World& world, std::span<Mover> movers, std::size_t a, std::size_t object_b, std::uint8_t b,
            float period_s, RenderCounters& counters) noexcept;
  void add(const World& world, std::span<Mover> movers, const Contact& contact, const Vec3& normal,
           std::size_t in_manifold, float period_s) noexcept;
  void warm(std::span<Mover> movers, Contact& contact) const noexcept;
  void move_apart(std::span<Mover> movers) noexcept;
  void keep() noexcept;

  static Row row(std::span<const Mover> movers, const Contact& contact, const Vec3& way) noexcept;
  static float speed(std::span<const Mover> movers, const Contact& contact, const Row& row) noexcept;
  static void push(std::span<Mover> movers, const Contact& contact, const Row& row, float impulse) noexcept;
  static void rub(std::span<Mover> movers, Contact& contact) noexcept;

  std::array<Contact, kMaxBodyContacts> contacts_;
  std::array<Kept, kMaxBodyContacts> kept_;
  std::size_t count_ = 0;
  std::size_t kept_count_ = 0;
};

}  // namespace thimble::control
