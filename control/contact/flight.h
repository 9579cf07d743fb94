// One flight of a god object that is a point: straight to a place, or to where it hits a surface.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/god_object.h"
#include "control/contact/nearby.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr float kOnePlace_m = 2.0F * kSurfaceTolerance_m;  // places on a surface that are one

// What the god object has slid off, and does not meet again on its flight. Within rounding of a vertex it can land on a face and slide off it
// to the same place: then it has left that face, too, or it would come back to it for ever.
struct Left {
  static constexpr std::size_t kMax = 6;
  std::array<Contact, kMax> contacts;
  std::size_t count = 0;

  void add(const Contact& contact) {
    if (count < kMax) contacts[count++] = contact;
  }
  [[nodiscard]] std::span<const Contact> all() const { return {contacts.data(), count}; }
};

enum class Outcome : std::uint8_t { kSettled, kContinue, kUnknown };

inline constexpr int kSkipNone = -1;

// Flies to `to`; where the flight hits an object, it stops there with one more contact. leaving: the contacts that it begins on, at most
// Left::kMax. skip: an object that is known not to be hit.
[[nodiscard]] Outcome fly_and_land(const World& world, const Nearby& nearby, std::span<const Contact> leaving,
                                   GodObject& god, const Vec3& to, int skip, bool& landed,
                                   Work& work) noexcept;

// The contacts of a god object that has moved along their surfaces, from -> point: those that it is still on, with the features there.
void update_contacts(const World& world, const Nearby& nearby, GodObject& god, const Vec3& from,
                     const Vec3& point, Work& work) noexcept;

}  // namespace thimble::control
