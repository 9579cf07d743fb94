#include "control/surfaces/click.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/surfaces/surface_view.h"
#include "kinematics/trig.h"

namespace thimble::control {
namespace {

static_assert(kMaxObjects <= 64, "one bit an object");

// exp(-x), 0 <= x: libm's differs from one target to the next. Taylor on x / 16, four times squared: within
// 1e-6.
float decay(float x) noexcept {
  constexpr float kParts = 16.0F;
  const float y = x / kParts;
  if (y > 1.0F) return 0.0F;
  float power = 1.0F - y * (1.0F - y / 2.0F * (1.0F - y / 3.0F * (1.0F - y / 4.0F * (1.0F - y / 5.0F))));
  for (int squared = 0; squared < 4; ++squared) power *= power;
  return power;
}

}  // namespace

void ContactClick::start(const World& world, const Constraints& held, const Tip& tip,
                         float period_s) noexcept {
  std::uint64_t touching = 0;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Constraint& c = held.list[i];
    const std::uint64_t bit = std::uint64_t{1} << c.object;
    touching |= bit;
    const ClickView& click = world.surfaces[c.object].click;
    constexpr float kFewestTicks = 4.0F;  // of one oscillation; a higher frequency cannot be rendered
    if ((touching_ & bit) != 0 || !(click.amplitude_N > 0.0F) ||
        click.frequency_Hz * period_s * kFewestTicks > 1.0F)
      continue;
    constexpr float kReference_m_s = 0.1F;
    constexpr float kFastest = 10.0F;  // times the reference: faster than any hand
    const float speed = std::clamp(-tip.velocity_m_s.dot(c.normal) / kReference_m_s, 0.0F, kFastest);
    const auto [sine, cosine] =
        kinematics::sin_cos(2.0F * std::numbers::pi_v<float> * click.frequency_Hz * period_s);
    const float left = decay(click.decay_per_s * period_s);
    constexpr float kEnd = 1.0e-3F;
    ringing_ = true;
    object_ = c.object;
    turn_cos_ = left * cosine;
    turn_sin_ = left * sine;
    cos_N_ = click.amplitude_N * speed;
    sin_N_ = 0.0F;
    least_N_ = kEnd * cos_N_;
  }
  touching_ = touching;
}

Vec3 ContactClick::next_transient(const Constraints& held, const Tip& tip, float period_s) noexcept {
  for (std::size_t i = 0; i < held.count; ++i) {
    if (held.list[i].object != object_) continue;
    Vec3 force = sin_N_ * held.list[i].normal;
    const float gives_J = force.dot(tip.velocity_m_s) * period_s;
    const float allowed_J = 0.5F * std::max(energy_budget_J_, 0.0F);
    if (gives_J > allowed_J) force *= allowed_J / gives_J;
    const float next_N = turn_cos_ * sin_N_ + turn_sin_ * cos_N_;
    cos_N_ = turn_cos_ * cos_N_ - turn_sin_ * sin_N_;
    sin_N_ = next_N;
    ringing_ = cos_N_ * cos_N_ + sin_N_ * sin_N_ > least_N_ * least_N_;
    return force;
  }
  ringing_ = false;  // another object is touched by now
  return Vec3::Zero();
}

Vec3 ContactClick::tick(const World& world, const Constraints& held, const Tip& tip, const Vec3& damping_N,
                        float period_s) noexcept {
  if (touching_ != 0) energy_budget_J_ -= last_force_N_.dot(tip.position_m - tip_m_);
  start(world, held, tip, period_s);
  Vec3 force = ringing_ ? next_transient(held, tip, period_s) : Vec3(Vec3::Zero());
  last_force_N_ = force + damping_N;
  tip_m_ = tip.position_m;
  return force;
}

}  // namespace thimble::control
