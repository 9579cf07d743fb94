// Fingertips on bodies, for the contact solver (control/bodies/contact_solver.h): moments about the normal that resist the spin of the body.
//
// A grip is solved as the turn of a contact patch is: within its limit it stops the spin, at the limit it is opposite to it, and while it sticks,
// the angle that is left of the iterations is returned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/solver_body.h"
#include "control/contact/god_object.h"
#include "control/scene/limits.h"
#include "kinematics/vector.h"

namespace thimble::control {

// A fingertip on a body: the patch of its skin is round the contact point, and a moment about the normal resists the
// spin of the body. The fingertip itself does not turn. Its force acts on the body elsewhere (Bodies::push).
struct Grip {
  std::uint8_t body = 0;
  std::uint8_t finger = 0;
  Vec3 normal;
  float normal_N = 0.0F;
  float static_friction = 0.0F;
  float dynamic_friction = 0.0F;
};

// The moment of a grip is at most the friction coefficient times the normal force times this radius: two thirds of the
// radius of the contact patch of a human fingertip pressed with 1 N, 5 mm, for even pressure.
inline constexpr float kGripRadius_m = 3.3e-3F;

// Each function takes at most a round over kMaxArms * kMaxContacts grips.
class GripContacts {
 public:
  void clear() noexcept { count_ = stored_count_ = 0; }
  void begin(std::span<const SolverBody> bodies, std::span<const Grip> grips, float period_s) noexcept;
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  // Takes over the moments of the last step.
  void prepare(std::span<const SolverBody> bodies) noexcept;
  void warm_start(std::span<SolverBody> bodies) noexcept;
  // Returns the largest change of velocity, at kGripRadius_m; a change by less than least_m_s is left out.
  float solve(std::span<SolverBody> bodies, float bias_per_s, float least_m_s) noexcept;
  void add_twist(std::span<const SolverBody> bodies, float period_s) noexcept;
  void decide_sliding() noexcept;
  void store() noexcept;
  // Twice the work of all of them in this step.
  [[nodiscard]] float work_twice_J(std::span<const SolverBody> bodies) const noexcept;

 private:
  struct Stored {  // for the next step
    std::uint8_t object = 0;
    std::uint8_t finger = 0;
    bool sliding = false;
    float moment_N_m_s = 0.0F;
    float twist_rad = 0.0F;  // while it sticks
    Vec3 normal = Vec3::Zero();
  };
  struct Row : Stored {
    std::uint8_t a = 0;
    float static_most_N_m_s = 0.0F;
    float dynamic_most_N_m_s = 0.0F;
    float inertia_kg_m2 = 0.0F;   // effective; 0: the body cannot turn about the normal
    Vec3 angular = Vec3::Zero();  // what a unit of the moment does to the spin

    [[nodiscard]] float most_N_m_s() const noexcept {
      return sliding ? dynamic_most_N_m_s : static_most_N_m_s;
    }
  };

  [[nodiscard]] std::span<Row> rows() noexcept { return {rows_.data(), count_}; }

  std::array<Row, kMaxArms * kMaxContacts> rows_;
  std::size_t count_ = 0;
  std::array<Stored, kMaxArms * kMaxContacts> stored_;
  std::size_t stored_count_ = 0;
};

}  // namespace thimble::control
