// The god object (proxy): a point that follows the tip and never enters a solid (Zilles and Salisbury 1995).
//
// Each tick it moves to the point nearest to the tip that it can reach. It flies until it hits a surface,
// then slides over the surface. Where it touches two or three surfaces, all their planes are solved together.
// Every piece of its path is swept against all objects nearby, so it is always at a place that was proven
// free. When a bound is hit it stays at such a place, and the bound is counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/nearby.h"
#include "control/contact/world.h"
#include "control/effort.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr std::size_t kMaxContacts = 3;  // one for each powered degree of freedom

class Resting;

struct Contact {
  std::uint8_t object = 0;
  Feature feature;

  bool operator==(const Contact&) const = default;
};

struct GodObject {
  Vec3 position_m = Vec3::Zero();
  std::array<Contact, kMaxContacts> contacts;
  std::size_t count = 0;  // 0: in free space
  // The last contact that stopped pushing while the god object may still lie on its surface. It keeps the
  // side of that surface, which the position alone does not tell.
  Contact beside;
  bool has_beside = false;
  // Where several solids are near (contact/ball.h): the centre of the ball over position_m, and the planes of the contacts.
  // Of a tip with a radius both are the same place.
  bool is_ball = false;
  Vec3 centre_m = Vec3::Zero();
  std::array<Vec3, kMaxContacts> normals;
};

[[nodiscard]] inline bool same_contacts(const GodObject& god,
                                        const std::array<Contact, kMaxContacts>& contacts) noexcept {
#pragma GCC unroll 1
  for (std::size_t i = 0; i < god.count; ++i)
    if (god.contacts[i] != contacts[i]) return false;
  return true;
}

// The other part of this object that the god object may lie on; null: none.
[[nodiscard]] inline const Feature* beside_on(const GodObject& god, std::uint8_t object) noexcept {
  return god.has_beside && god.beside.object == object ? &god.beside.feature : nullptr;
}

// Whether nothing but this object holds it.
[[nodiscard]] inline bool on_one_object(const GodObject& god, std::uint8_t object) noexcept {
  for (std::size_t i = 0; i < god.count; ++i)
    if (god.contacts[i].object != object) return false;
  return true;
}

// From the god object to the place where the tip touches the surface of a contact: the radius of the tip, against the
// normal.
[[nodiscard]] inline Vec3 to_place(const World& world, const GodObject& god, std::size_t contact) noexcept {
  return world.tip_radius_m > 0.0F ? Vec3(-world.tip_radius_m * god.normals[contact]) : Vec3(Vec3::Zero());
}

// A contact constraint: one plane that holds the god object back, F += K lambda n. The material is that of
// the object, until the effects of its surface change it (control/surfaces).
struct Constraint {
  std::uint8_t object = 0;
  Vec3 normal = Vec3::UnitZ();
  float lambda_m = 0.0F;
  Material material;
  std::uint8_t contact = 0;        // of the god object
  Vec3 to_place_m = Vec3::Zero();  // to_place() of its contact
};

struct Constraints {
  std::array<Constraint, kMaxContacts> list;
  std::size_t count = 0;
};

// Where several solids are near, or the tip has a radius, both move it as a ball (contact/ball.h).
//
// Moves a god object in free space to `target`, or to the place where its flight hits a surface.
void fly(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
         Effort& effort) noexcept;

// Moves the god object to the point nearest to `target` that it can reach. hold: it stays on its surface, for
// targets near the surface itself (friction, shading).
void move(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
          Effort& effort) noexcept;

// Writes the unit normals of the planes that the god object lies on, towards the free side, world frame;
// returns how many.
std::size_t contact_normals(const World& world, const GodObject& god,
                            std::span<Vec3, kMaxContacts> normals) noexcept;

// The contact constraints: splits god - tip over the planes that hold the god object, sum of lambda n = god -
// tip, lambda >= 0. resting: of the finger (contact/planes.h). Replaces what `held` was.
void find_constraints(const World& world, const GodObject& god, const Vec3& tip, Resting& resting,
                      Constraints& held) noexcept;

}  // namespace thimble::control
