#include "control/contact/reaction.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "control/contact/damping.h"

namespace thimble::control {
namespace {

constexpr float kHeldSpeed_m_s = 0.015F;

// god_m: the god object.
Vec3 damping_force(const World& world, const Bodies& bodies, const Constraint& c, const Vec3& god_m,
                   const Vec3& velocity) {
  const Material& m = c.material;
  if (!(m.damping_N_s_m > 0.0F)) return Vec3::Zero();
  const float speed =
      relative_velocity(world.objects[c.object], bodies, god_m + c.to_place_m, velocity).dot(c.normal);
  return damping_force_N(m.stiffness_N_m * c.lambda_m, m.damping_N_s_m, speed) * c.normal;
}

// The part of a velocity along all surfaces that hold the god object.
Vec3 along_surfaces(const Constraints& held, const Vec3& velocity) {
  const Vec3& normal = held.list[0].normal;
  if (held.count == 1) return velocity - normal * normal.dot(velocity);
  if (held.count > 2) return Vec3::Zero();
  const Vec3 edge = normal.cross(held.list[1].normal);
  const float square = edge.squaredNorm();
  return square > 0.0F ? Vec3(edge * (edge.dot(velocity) / square)) : Vec3(Vec3::Zero());
}

}  // namespace

Vec3 relative_velocity(const PlacedObject& object, const Bodies& bodies, const Vec3& at,
                       const Vec3& velocity) noexcept {
  return object.body == kNoBody ? velocity : Vec3(velocity - bodies.velocity_at(object.body, at));
}

Vec3 damping_force(const World& world, const Bodies& bodies, const Constraints& held, const Vec3& god_m,
                   const Vec3& velocity) noexcept {
  Vec3 force = Vec3::Zero();
  for (std::size_t i = 0; i < held.count; ++i)
    force += damping_force(world, bodies, held.list[i], god_m, velocity);
  return force;
}

Vec3 damping_along(const World& world, const Bodies& bodies, const Finger& finger, const Constraints& held,
                   const Vec3& velocity, const Vec3& friction_N, const FrictionLimits& limits,
                   float period_s) noexcept {
  if (bodies.empty() || limits.static_m <= 0.0F) return Vec3::Zero();
  const float limit_N =
      limits.stiffness_N_m * (finger.friction.sliding() ? limits.dynamic_m : limits.static_m);
  Vec3 total = Vec3::Zero();
  for (std::size_t i = 0; i < held.count; ++i) {
    const PlacedObject& object = world.objects[held.list[i].object];
    const float damping_N_s_m = held.list[i].material.damping_N_s_m / static_cast<float>(held.count);
    if (object.body == kNoBody || damping_N_s_m <= 0.0F) continue;
    const Vec3 at = finger.god.position_m + held.list[i].to_place_m;
    const Vec3 along = along_surfaces(held, relative_velocity(object, bodies, at, velocity));
    const float speed = along.norm();
    if (speed <= 0.0F) continue;
    const float most_N_s_m = 0.5F * bodies.mass_at(object.body, at, along / speed) / period_s;
    total -= std::min({damping_N_s_m, most_N_s_m, damping_N_s_m * kHeldSpeed_m_s / speed}) * along;
  }
  // The share of it with which |friction + share total| is at the limit.
  const float square = total.squaredNorm();
  const float room2 = limit_N * limit_N - friction_N.squaredNorm();
  if (square <= 0.0F || room2 <= 0.0F) return Vec3::Zero();
  const float along = friction_N.dot(total);
  const float share = (std::sqrt(along * along + square * room2) - along) / square;
  return std::min(share, 1.0F) * total;
}

void push_back(const World& world, Bodies& bodies, std::uint8_t finger, const Constraints& held,
               const Vec3& god_m, const Vec3& velocity, const Vec3& force) noexcept {
  std::array<Vec3, kMaxContacts> own;
  std::array<float, kMaxContacts> holds;
  Vec3 rest = force;
  float all = 0.0F;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Constraint& c = held.list[i];
    const Material& m = c.material;
    const float push = m.stiffness_N_m * c.lambda_m;
    own[i] = push * c.normal + damping_force(world, bodies, c, god_m, velocity);
    rest -= own[i];
    holds[i] = m.static_friction * push;
    all += holds[i];
  }
  for (std::size_t i = 0; i < held.count; ++i) {
    const PlacedObject& object = world.objects[held.list[i].object];
    if (object.body == kNoBody) continue;
    const float share = all > 0.0F ? holds[i] / all : 1.0F / static_cast<float>(held.count);
    const Constraint& c = held.list[i];
    const Material& m = c.material;
    const Vec3 at = god_m + c.to_place_m;
    if (m.static_friction > 0.0F && c.lambda_m > 0.0F) {
      bodies.grip({object.body, finger, c.normal, m.stiffness_N_m * c.lambda_m, m.static_friction,
                   m.dynamic_friction});
    }
    bodies.push(object.body, at, held.count == 1 ? Vec3(-force) : Vec3(-own[i] - share * rest));
  }
}

}  // namespace thimble::control
