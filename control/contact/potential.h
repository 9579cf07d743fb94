// Whether the force of a contact is the gradient of one potential, from tick to tick.
//
// The springs of a contact have the potential U = sum K depth^2 / 2 over the objects when all have the same stiffness or their
// planes are perpendicular. Where the god object slides from one object to an object of another stiffness, U changes in that tick without
// work: the potential does not go on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contact/god_object.h"

namespace thimble::control {

class ContactPotential {
 public:
  // Once a tick in contact. step_m: how far the tip moved since the last tick. True if the force is the gradient of the
  // potential that held in the last tick, or if no contact was before.
  bool goes_on(const Constraints& held, float step_m) noexcept;

  // The same, true at once: one object holds the tip, as in the last tick.
  bool stays(const Constraints& held) noexcept {
    if (held.count != 1 || before_.count != 1 || before_.object[0] != held.list[0].object) return false;
    before_.stiffness_N_m = held.list[0].material.stiffness_N_m;
    return true;
  }

  void end() noexcept { before_.count = 0; }

 private:
  // What the tip is pressed into, by object.
  struct Depths {
    std::array<std::uint8_t, kMaxContacts> object{};
    std::array<float, kMaxContacts> depth_m{};
    std::size_t count = 0;
    float stiffness_N_m = 0.0F;  // of all; 0: they differ
  };
  static Depths depths(const Constraints& held) noexcept;
  [[nodiscard]] float depth_before(std::uint8_t object) const noexcept;

  Depths before_;
};

// The energy in the springs of a contact, J; continuous where a plane begins or ceases to hold. Between planes that are not perpendicular it is
//   sum K lambda^2 / 2 + sum over pairs (n_i . n_j) lambda_i lambda_j (K_i lambda_i + K_j lambda_j) / (lambda_i + lambda_j)
// which is K |sum lambda n|^2 / 2 for equal stiffness, and never negative. The sum of K lambda n is its gradient only for equal stiffness or
// perpendicular planes.
[[nodiscard]] float spring_energy_J(const Constraints& held) noexcept;

}  // namespace thimble::control
