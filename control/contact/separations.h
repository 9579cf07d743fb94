// Planes between a ball and the solids near it. A ball in front of all of them meets no solid, whichever way it
// moves there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/god_object.h"
#include "control/contact/half_spaces.h"
#include "control/contact/world.h"
#include "control/solids/solid.h"
#include "kinematics/vector.h"

namespace thimble::control {

// World frame. `planes` bound the centre's displacement from where it is.
struct Separations {
  static constexpr std::size_t kMax = 48;

  std::array<HalfSpace, kMax> planes;
  std::array<Separation, kMax> of;
  std::array<std::uint8_t, kMax> object;
  std::size_t count = 0;
  float free_m = 0.0F;  // the centre may move no farther: parts of solids that found no room are beyond

  // The parts of solids that the ball touches.
  struct Held {
    std::array<std::uint8_t, 3> object{};
    std::array<std::uint32_t, 3> feature{};
    std::size_t count = 0;
  };

  // False when there is no room for all, or the work is spent. A solid that holds the centre deeper than its radius is left out: the ball
  // began in it.
  [[nodiscard]] bool look(const World& world, const Nearby& nearby, const BallQuery& ball,
                          const Held& held) noexcept;

  // The displacement nearest to `way`. A ball that is squeezed between solids keeps its place there, and does not go
  // deeper.
  [[nodiscard]] NearestInside nearest(const Vec3& way, Work& work) noexcept;

  [[nodiscard]] std::span<const HalfSpace> all() const { return {planes.data(), count}; }
  [[nodiscard]] bool touches(std::size_t i, float radius_m) const {
    return of[i].apart_m <= radius_m + kTouchGap_m && of[i].height_m <= radius_m + kTouchGap_m;
  }

 private:
  [[nodiscard]] bool goes_on(std::size_t face) const;  // there is a level face beside it
};

}  // namespace thimble::control
