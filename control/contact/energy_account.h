// Prevents contacts whose force is not the gradient of a potential from giving energy to the hand.
//
// Force shading turns the force away from the true normal, and a corner between objects of different
// stiffness has no potential. Where the god object slides from a soft object to a stiff one, the same depth
// stores more energy than before. A closed path of the tip could then return more energy than it took. The
// account holds the work W that the hand has done on the surfaces since contact began, and the energy U that is
// stored in the springs and that a release would return.
//
// While W >= U the force is unchanged. Otherwise there is a debt D, and the force is scaled by s = 1 - (D /
// U)^2 and keeps its direction. This is the force of the potential V = (U - D)^2 / U, and D is chosen so that
// V = W. So the work done always covers the energy that can be returned, and no path gives energy. The scale
// is continuous, and a debt from a light contact has little effect on a firm one.
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
  // depth_m: from the tip to the god object.
  float tick(std::uint8_t body, const Vec3& tip_m, float depth_m, float stored_J,
             const Vec3& spring_force_N) noexcept {
    const Vec3 step = tip_m_ - tip_m;
    exact_ = false;
    // No hand moves further than this in one tick (2 m/s at 4 kHz). When such a step is also longer than the
    // depth, its path is unknown, and the stored energy counts as work done.
    constexpr float kJump_m = 5.0e-4F;
    const float step2 = step.squaredNorm();
    if (!goes_on(body) || (step2 > kJump_m * kJump_m && step2 > depth_m * depth_m)) {
      open_ = true;
      body_ = body;
      work_J_ = stored_J;
      debt_J_ = 0.0F;
      applied_N_ = spring_force_N;
      tip_m_ = tip_m;
      return 1.0F;
    }
    const float part = stored_J > debt_J_ ? debt_J_ / stored_J : 1.0F;
    const float scale = debt_J_ > 0.0F ? 1.0F - part * part : 1.0F;
    // A negative sum is energy that a tick gave before its debt was known: the debt is then more than what is stored.
    work_J_ += 0.5F * (applied_N_ + scale * spring_force_N).dot(step);
    // One part in 10^4 covers the rounding of a long contact.
    constexpr float kSlack = 1.0001F;
    const float root_J = std::sqrt(std::abs(work_J_) * stored_J);
    debt_J_ = work_J_ * kSlack < stored_J ? stored_J - std::copysign(root_J, work_J_) : 0.0F;
    applied_N_ = scale * spring_force_N;
    tip_m_ = tip_m;
    return scale;
  }

  void close() noexcept { open_ = false; }

 private:
  [[nodiscard]] bool goes_on(std::uint8_t body) const noexcept { return open_ && body_ == body; }

  bool open_ = false;
  bool exact_ = false;
  std::uint8_t body_ = 0;
  float work_J_ = 0.0F;
  float debt_J_ = 0.0F;
  Vec3 applied_N_ = Vec3::Zero();
  Vec3 tip_m_ = Vec3::Zero();
};

}  // namespace thimble::control
