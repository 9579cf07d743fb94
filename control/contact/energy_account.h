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
//   V = e U + (1 - e) U^2 / (U + D)  from then on, as the force must not end inside: s is at least e, 0.15, and where W
//                                    covers less than that part of U, up to twice W / U. How fast s changes is limited too.
//                                    A hand that presses gets at least 2 W / U, so that depth covers the debt of a light touch.
// Where U jumps, or the force is not its gradient, D grows in the same tick, so that no force comes before the debt.
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
    debt_ = {};
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
  // falls: where the spring force is bound to the last tick's (ShadedForce), how fast the scale may fall; 0: at once, as U may jump.
  float tick(std::uint8_t body, const Vec3& tip_m, float depth_m, float stored_J, const Vec3& spring_force_N,
             bool shaded, float falls) noexcept {
    const Vec3 step = tip_m_ - tip_m;
    exact_ = false;
    // No hand moves further than this in one tick (2 m/s at 4 kHz). When such a step is also longer than the
    // depth, its path is unknown, and the stored energy counts as work done.
    constexpr float kJump_m = 5.0e-4F;
    const float step2 = step.squaredNorm();
    const float depth2 = depth_m * depth_m;
    if (!goes_on(body) || (step2 > kJump_m * kJump_m && step2 > depth2)) {
      open_ = true;
      body_ = body;
      work_J_ = stored_J;
      scale_ = 1.0F;
    } else {
      const float half_J = 0.5F * spring_force_N.dot(step);
      work_J_ += 0.5F * applied_N_.dot(step);
      const float before = scale_;
      scale_ = shaded == shaded_ ? scale_with(debt_, stored_J) : 1.0F;
      // The trapezoidal sum of a scaled force is off by up to the last term.
      constexpr float kPart = 0.5F;
      const float expected_J = work_J_ + scale_ * half_J + kPart * std::abs((scale_ - before) * half_J);
      if (expected_J * kSlack < stored_J)
        scale_ = std::min(scale_, scale_with(debt_of(expected_J, stored_J, shaded), stored_J));
      // A hand that presses does work. So it can cover U again where nothing of U is covered.
      constexpr float kBegins = 0.01F;
      if (half_J > 0.0F)
        scale_ = std::max(scale_, shaded ? std::clamp(2.0F * work_J_ / stored_J, kBegins, 1.0F) : kBegins);
      // With a spring force that changes by at most 1.4 K times the motion (ShadedForce), the scaled one changes by less than
      // twice K times the motion. Where U may jump, a limit on the fall would give energy.
      if (shaded && (before < 1.0F || scale_ < 1.0F)) {
        const float most = (1.9F - 1.4F * before) * std::sqrt(step2 / std::max(depth2, step2));
        scale_ = std::clamp(scale_, falls > 0.0F && before > kBegins ? before - falls * most : 0.0F,
                            before + most);
        if (scale_ * half_J < -std::max(work_J_, 0.0F)) scale_ = std::max(work_J_, 0.0F) / -half_J;
      }
      work_J_ += scale_ * half_J;
    }
    shaded_ = shaded;
    debt_ = debt_of(work_J_, stored_J, shaded);
    applied_N_ = scale_ * spring_force_N;
    tip_m_ = tip_m;
    return scale_;
  }

  // Of the last tick in this contact.
  [[nodiscard]] float scale() const noexcept { return open_ ? scale_ : 1.0F; }

  void close() noexcept { open_ = false; }

 private:
  struct Debt {
    float debt_J = 0.0F;
    float least = 0.0F;  // e of the law with shading; negative: the law without
  };

  // One part in 10^4 covers the rounding of a long contact.
  static constexpr float kSlack = 1.0001F;

  // With which V = W.
  [[nodiscard]] static Debt debt_of(float work_J, float stored_J, bool shaded) noexcept {
    constexpr float kLeast = 0.15F;
    constexpr float kLittle = 1.0e-6F;  // a debt is finite
    if (work_J * kSlack >= stored_J) return {};
    const float covered = std::max(work_J * kSlack / stored_J, kLittle);
    const float all_J = std::max(stored_J, -work_J);  // where more has been given than is stored
    if (!shaded) return {all_J * (1.0F - std::sqrt(covered)), -1.0F};
    const float least = std::min(kLeast, covered * covered / kLeast);
    return {all_J * (1.0F - covered) / std::max(covered - least, kLittle), least};
  }

  // dV/dU.
  [[nodiscard]] static float scale_with(const Debt& debt, float stored_J) noexcept {
    if (debt.debt_J <= 0.0F) return 1.0F;
    if (debt.least < 0.0F) {
      const float part = stored_J > debt.debt_J ? debt.debt_J / stored_J : 1.0F;
      return 1.0F - part * part;
    }
    const float part = debt.debt_J / (stored_J + debt.debt_J);
    return 1.0F - (1.0F - debt.least) * part * part;
  }

  [[nodiscard]] bool goes_on(std::uint8_t body) const noexcept { return open_ && body_ == body; }

  bool open_ = false;
  bool exact_ = false;
  bool shaded_ = false;  // the law of the debt
  std::uint8_t body_ = 0;
  float work_J_ = 0.0F;
  Debt debt_;
  float scale_ = 1.0F;
  Vec3 applied_N_ = Vec3::Zero();
  Vec3 tip_m_ = Vec3::Zero();
};

}  // namespace thimble::control
