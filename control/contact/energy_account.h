// Prevents contacts whose force is not the gradient of a potential from giving energy to the hand.
//
// Force shading turns the force away from the true normal, and a corner between objects of different
// stiffness has no potential. Where the god object slides from a soft object to a stiff one, the same depth
// stores more energy than before. A closed path of the tip could then return more energy than it took. The
// account holds the work W that the hand has done on the surfaces since contact began, and the energy U that is
// stored in the springs and that a release would return.
//
// While W >= U the force is unchanged. Otherwise there is a debt D, and the force is scaled by s = dV/dU of a potential
// V(U) and keeps its direction. D is chosen so that V = W. So the work done always covers the energy that can be returned, and
// no path gives energy. The scale is continuous, and a debt from a light contact has little effect on a firm one.
//   V = (U - D)^2 / U                until a shaded mesh takes part in the contact. Where U falls to D, the force ends.
//   V = c U + (1 - c) U^2 / (U + D)  from then on, as the force must not end inside: s is at least c, 0.15, and where W
//                                    covers less than that part of U, almost W / U. How fast s changes is limited too.
//
// The work is summed by the trapezoidal rule. It is exact for a spring, so pressing and releasing alone never
// changes the scale. Source of the idea: the passivity observer of Hannaford and Ryu 2002, here with a known
// stored energy.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kinematics/vector.h"

namespace thimble::control {

class EnergyAccount {
 public:
  // Of all functions: places and forces are in the frame of `body`, an index into the scene's bodies, or in the world's for kNoBody.
  // An account does not go on from frame to frame.

  // Called instead of tick() in a contact whose force is the gradient of one potential since it began: the work
  // done is the energy stored, without the rounding of a sum.
  void follow(std::uint8_t body, const Vec3& tip_m, float stored_J, const Vec3& spring_force_N) noexcept {
    open_ = exact_ = true;
    scale_ = 1.0F;
    body_ = body;
    work_J_ = stored_J;
    debt_J_ = 0.0F;
    applied_N_ = spring_force_N;
    tip_m_ = tip_m;
  }

  // Whether follow() may be called for a contact with a potential: no tick since the contact began needed tick().
  [[nodiscard]] bool exact(std::uint8_t body) const noexcept { return exact_ || !goes_on(body); }

  // How far the tip has moved since the last tick in contact; infinite if there was none in this frame.
  [[nodiscard]] float step_m(std::uint8_t body, const Vec3& tip_m) const noexcept {
    return goes_on(body) ? (tip_m - tip_m_).norm() : std::numeric_limits<float>::infinity();
  }

  // Called once a tick in contact with the spring force before scaling; returns the scale, 0 to 1.
  // depth_m: from the tip to the god object. shaded: a shaded mesh has taken part in the contact.
  // bound: the spring force is bound to the last tick's (ShadedForce), so U does not jump.
  float tick(std::uint8_t body, const Vec3& tip_m, float depth_m, float stored_J, const Vec3& spring_force_N,
             bool shaded, bool bound) noexcept {
    const Vec3 step = tip_m_ - tip_m;
    exact_ = false;
    // No hand moves further than this in one tick (2 m/s at 4 kHz). When such a step is also longer than the
    // depth, its path is unknown, and the stored energy counts as work done.
    constexpr float kJump_m = 5.0e-4F;
    const float step2 = step.squaredNorm();
    if (!goes_on(body) || (step2 > kJump_m * kJump_m && step2 > depth_m * depth_m)) {
      open_ = true;
      shaded_ = shaded;
      body_ = body;
      work_J_ = stored_J;
      debt_J_ = 0.0F;
      scale_ = 1.0F;
      applied_N_ = spring_force_N;
      tip_m_ = tip_m;
      return 1.0F;
    }
    if (shaded != shaded_) {
      shaded_ = shaded;
      owe(stored_J);
    }
    if (shaded) {
      const float most = most_change(step2, depth_m * depth_m);
      scale_ = std::clamp(shaded_scale(stored_J), bound ? scale_ - most : 0.0F, scale_ + most);
    } else {
      const float part = stored_J > debt_J_ ? debt_J_ / stored_J : 1.0F;
      scale_ = debt_J_ > 0.0F ? 1.0F - part * part : 1.0F;
    }
    work_J_ += 0.5F * (applied_N_ + scale_ * spring_force_N).dot(step);
    owe(stored_J);
    applied_N_ = scale_ * spring_force_N;
    tip_m_ = tip_m;
    return scale_;
  }

  // Of the last tick in this contact.
  [[nodiscard]] float scale() const noexcept { return open_ ? scale_ : 1.0F; }

  void close() noexcept { open_ = false; }

 private:
  [[nodiscard]] float shaded_scale(float stored_J) const noexcept {
    const float part = debt_J_ > 0.0F ? debt_J_ / (stored_J + debt_J_) : 0.0F;
    return 1.0F - (1.0F - least_) * part * part;
  }

  // With a spring force that changes by at most 1.4 K times the motion (ShadedForce), the scaled one changes by less than twice K
  // times the motion. Where U may jump, a limit on the fall would give energy.
  [[nodiscard]] float most_change(float step2, float depth2) const noexcept {
    return (1.9F - 1.4F * scale_) * std::sqrt(step2 / std::max(depth2, step2));
  }

  // Sets the debt for which V = W.
  void owe(float stored_J) noexcept {
    // One part in 10^4 covers the rounding of a long contact.
    constexpr float kSlack = 1.0001F;
    debt_J_ = 0.0F;
    if (work_J_ * kSlack >= stored_J) return;
    if (shaded_) {
      constexpr float kLeast = 0.15F;
      constexpr float kNext = 0.98F;  // of W / U: below it V = W has a solution
      constexpr float kNone = 1.0e-4F;
      const float covered = std::max(work_J_ * kSlack / stored_J, kNone);
      least_ = std::min(kLeast, kNext * covered);
      debt_J_ = stored_J * (1.0F - covered) / (covered - least_);
    } else {
      // A negative sum is energy that a tick gave before its debt was known: the debt is then more than what is stored.
      debt_J_ = stored_J - std::copysign(std::sqrt(std::abs(work_J_) * stored_J), work_J_);
    }
  }

  [[nodiscard]] bool goes_on(std::uint8_t body) const noexcept { return open_ && body_ == body; }

  bool open_ = false;
  bool exact_ = false;
  bool shaded_ = false;  // the law of the debt
  std::uint8_t body_ = 0;
  float work_J_ = 0.0F;
  float debt_J_ = 0.0F;
  float least_ = 0.0F;  // c of the law with shading
  float scale_ = 1.0F;
  Vec3 applied_N_ = Vec3::Zero();
  Vec3 tip_m_ = Vec3::Zero();
};

}  // namespace thimble::control
