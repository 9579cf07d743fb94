// The force limits of one arm: vector clamp, slew limit, and what they may give back. Called every tick. A limit says whether it acted;
// neither turns the vector it limits (the clamp keeps the force's direction, the slew limit the direction of its change).
//
// Expects finite vectors; cannot fail. Units: N.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinematics/limited.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

using LimitedForce = kinematics::Limited<Vec3, bool>;

inline constexpr float kLimitSlew_N_s = 50.0F;    // how fast a change of max_force takes effect
inline constexpr float kUncommissioned_N = 1.0F;  // most of an arm that has not passed a commissioning

[[nodiscard]] inline LimitedForce clamp_force(const Vec3& force_N, float max_N) noexcept {
  const float norm = std::sqrt(force_N.squaredNorm());
  if (!(norm > max_N)) return {force_N, false};
  return {force_N * (max_N / norm), true};
}

[[nodiscard]] inline LimitedForce slew_force(const Vec3& force_N, const Vec3& last_N,
                                             float max_step_N) noexcept {
  const LimitedForce step = clamp_force(force_N - last_N, max_step_N);
  if (!step.which) return {force_N, false};
  return {last_N + step.value, true};
}

// What is left of the last force once the part that the new one no longer has is gone: a step from there falls at once.
[[nodiscard]] inline Vec3 remaining(const Vec3& last_N, const Vec3& force_N) noexcept {
  const float norm2 = last_N.squaredNorm();
  return (norm2 > 0.0F ? std::clamp(force_N.dot(last_N) / norm2, 0.0F, 1.0F) : 0.0F) * last_N;
}

// Keeps ramp and limits from giving the hand the energy of a rendered contact: a wall that was pressed against a small force does not
// push back with a larger one. Counts what the wanted force holds of the hand's work, and what the limited one does. While that is a
// part of the wanted force's only, the hand is given that part of the force. What holds nothing, as a field, is not counted.
class ForceAccount {
 public:
  // At arming: the maximum, and where the tip is.
  void start(float max_N, const Vec3& tip_m) noexcept {
    *this = {};
    max_N_ = max_N;
    tip_m_ = tip_m;
  }

  // The maximum falls by step_N a tick. It rises at once while it does not act, so that the force does not rise; otherwise by step_N, and
  // in a contact of this depth only as fast as a debt is forgotten.
  [[nodiscard]] float max_N(float wanted_max_N, float force_N, float depth_m, float step_N,
                            float period_s) noexcept {
    if (wanted_max_N < max_N_) {
      max_N_ = std::max(wanted_max_N, max_N_ - step_N);
    } else if (depth_m > 0.0F && force_N <= max_N_) {
      max_N_ = wanted_max_N;
    } else {
      const float rise_N = depth_m > 0.0F ? std::min(step_N, kForgotten_W * period_s / depth_m) : step_N;
      max_N_ = std::min(wanted_max_N, max_N_ + rise_N);
    }
    return max_N_;
  }

  // The part of the wanted force, which is clamped, that the hand has paid for, 0 to 1: after a move to tip_m in a tick of period_s.
  [[nodiscard]] float paid(const Vec3& tip_m, const Vec3& wanted_N, float period_s) noexcept {
    const Vec3 moved_m = tip_m - tip_m_;
    tip_m_ = tip_m;
    wanted_J_ = std::max(wanted_J_ - wanted_N_.dot(moved_m), 0.0F);
    limited_J_ = std::clamp(limited_J_ - limited_N_.dot(moved_m) + kForgotten_W * period_s, 0.0F, wanted_J_);
    if (std::exchange(another_scene_, false)) {
      const float before_N = wanted_N_.norm();
      if (before_N > 0.0F) wanted_J_ *= wanted_N.norm() / before_N;
      limited_J_ = std::min(limited_J_, wanted_J_);
    }
    return wanted_J_ > 0.0F ? limited_J_ / wanted_J_ : 1.0F;
  }

  // The forces of this tick: clamped, and as limited. held_J: the most that the wanted force can hold of the hand's work; what is beyond
  // it, friction has taken.
  void add(const Vec3& wanted_N, const Vec3& limited_N, float held_J) noexcept {
    if (wanted_J_ > held_J) {
      limited_J_ *= held_J / wanted_J_;
      wanted_J_ = held_J;
    }
    wanted_N_ = wanted_N;
    limited_N_ = limited_N;
  }

  // The next wanted force is another scene's. A contact that goes on in it may be stiffer than the one that the hand has paid for.
  void another_scene() noexcept { another_scene_ = true; }

 private:
  // So fast a debt is forgotten: a wall of 1000 N/m that was met half as hard is itself again after 0.2 s, 2 mm deep. A hand does not feel
  // so little power.
  static constexpr float kForgotten_W = 5e-3F;

  float max_N_ = 0;
  Vec3 tip_m_ = Vec3::Zero(), wanted_N_ = Vec3::Zero(), limited_N_ = Vec3::Zero();
  float wanted_J_ = 0, limited_J_ = 0;  // held in this contact
  bool another_scene_ = false;
};

}  // namespace thimble::firmware
