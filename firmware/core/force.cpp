#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/core/force_limits.h"
#include "firmware/core/steps.h"
#include "kinematics/directions.h"

namespace thimble::firmware {
namespace {

float max_force_N(const Parts& parts, std::size_t arm) noexcept {
  return std::min(parts.params.get(Param::max_force), parts.setup.arm[arm].data().max_force_N);
}

// One source's forces. False: one is not finite, which is a fault.
bool ask(Parts& parts, ForceSource& source, SourceForces& out) noexcept {
  source.forces(source_tick(parts), out);
  for (control::Touch& touch : out.arms) {
    if (finite(touch.force_N)) continue;
    touch = {};
    trip(parts, Fault::force_not_finite);
    return false;
  }
  return true;
}

// The force at the tip that asks the axes for these torques, or comes nearest to it.
Vec3 force_of(const kinematics::Arm<float>& arm, const kinematics::Posture<float>& posture,
              const Axes& torque_N_m) noexcept {
  if (!arm.is_two_link())
    return kinematics::directions_of(arm.driven_jacobian(posture))
        .force_of(torque_N_m, kinematics::kLeastLever_m);
  const kinematics::Matrix3<float> jacobian = posture.jacobian.leftCols<3>();
  return jacobian.transpose().inverse() * torque_N_m.head<3>();
}

// What the arm can give of a force near a singularity.
Vec3 faded(Parts& parts, std::size_t index, const Vec3& force_N) noexcept {
  const kinematics::Arm<float>& geometry = parts.setup.arm[index];
  if (geometry.is_two_link()) return force_N;
  ArmState& arm = parts.state.arm[index];
  const kinematics::ForceFade::Faded left =
      parts.setup.fade[index].of(geometry.driven_jacobian(arm.posture), force_N);
  if (left.faded) arm.limiters |= kLimitSingular;
  return left.force_N;
}

// What a probe of the encoders leaves of the force: of the torques that it asks of the joints, so it has another direction, but is no
// greater. wanted_N is before the account of the energy, which takes from the force while a hand follows the probe. What the limits of
// the motors keep back proves nothing when it is taken away.
// No force asks a redundant arm for these torques: the one that comes nearest to them would leave the joint much of its torque, and then
// it may rest by its friction, while others carry the hand. So drive.cpp takes from the torques themselves. The nearest force is what they
// give at the tip all the same: the rest works on motions that leave the tip where it is. The account of the energy counts it. With the
// whole force a hand that follows the probe into a wall would be taken to have done more work than it has.
Vec3 probed(Parts& parts, std::size_t index, const Vec3& wanted_N, const Vec3& force_N) noexcept {
  ArmState& arm = parts.state.arm[index];
  const kinematics::Arm<float>& geometry = parts.setup.arm[index];
  const auto& jacobian = arm.posture.jacobian;
  Axes torque_N_m;
  const bool probed_before = arm.probe.probes();
  const bool may_rest = parts.setup.has_line_loss[index] || arm.source != nullptr;
  for (std::size_t j = 0; j < arm.axes; ++j) {
    const int axis = static_cast<int>(j);
    torque_N_m[axis] = jacobian.col(axis).dot(force_N);
    if (!geometry.is_driven(axis)) continue;
    // With the other joints at rest. That is the worst case, of a redundant arm too: these keep their torques, so they only move where the
    // hand, as it gives way to this joint, overcomes their friction, and then they give way with it. Of two that are probed at once the
    // looser one counts first, gets its torque back, and leaves the way to the other.
    const float sure_N_m =
        parts.setup.joint[index][j].against_hand.torque_N_m(jacobian.col(axis).squaredNorm());
    const float asked_N_m =
        probed_before && arm.probe.part(j) < 1.0F ? jacobian.col(axis).dot(wanted_N) : torque_N_m[axis];
    arm.probe.watch(j,
                    {.counts = arm.encoder[j].counts(),
                     .pushes_up = torque_N_m[axis] * arm.encoder[j].rad_per_count() > 0.0F,
                     .holds = arm.given * std::abs(asked_N_m) > sure_N_m,
                     .changed = arm.suspect[j],
                     .may_rest = may_rest},
                    parts.setup.period_s);
    if (arm.probe.reversed(j)) trip(parts, Fault::motor_reversed);
  }
  if (!arm.probe.probes()) return force_N;
  for (std::size_t j = 0; j < arm.axes; ++j) torque_N_m[static_cast<int>(j)] *= arm.probe.part(j);
  if (!probed_before) ++parts.state.telemetry.probes;
  arm.limiters |= kLimitProbe;
  if (arm.probe.dead()) {
    trip(parts, Fault::encoder_frozen);
    arm.homed = false;
  }
  const Vec3 left_N = force_of(geometry, arm.posture, torque_N_m);
  return finite(left_N) ? clamp_force(left_N, force_N.norm()).value
                        : Vec3::Zero();  // not in a singular posture
}

// Whether the brake may go on: it slows the tip. If it does not, a hand moves the tip, which a brake would only drag, or a motor does not
// do what it is told. At 2 N s/m a free tip of 0.4 kg slows down like this.
bool slows(State& state, float period_s) noexcept {
  constexpr float kSlowed_s = 0.2F, kMore_m_s = 0.05F;
  for (ArmState& arm : state.arm) {
    const float speed_m_s = arm.tip_velocity_m_s.norm();
    if (state.mode_time_s == 0.0F) arm.braked_m_s = speed_m_s;
    if (speed_m_s > arm.braked_m_s + kMore_m_s) return false;
    arm.braked_m_s = std::min(arm.braked_m_s, speed_m_s) * (1.0F - period_s / kSlowed_s);
  }
  return true;
}

}  // namespace

SourceOutcome apply_source(Parts& parts) noexcept {
  State& state = parts.state;
  SourceForces out{std::span(state.touch).first(parts.setup.arm_count)};
  if (!ask(parts, *state.source, out)) return {};
  state.in_contact = std::any_of(out.arms.begin(), out.arms.end(),
                                 [](const control::Touch& touch) { return touch.contacts != 0; });
  for (std::size_t i = 0; i < parts.setup.arm_count && state.guest; ++i)
    if (state.arm[i].source != nullptr && !ask(parts, *state.arm[i].source, out)) return {};
  if (out.let_go) happen(parts, Event::kLetGo, StoppedBy::kLetGo);
  return {!out.let_go, out.clamped};
}

void end_guest(Parts& parts) noexcept {
  State& state = parts.state;
  if (!state.guest) return;
  parts.sources.move.stop();
  parts.sources.axes.stop();
  for (std::size_t i = 0; i < state.arm.size(); ++i) {
    state.arm[i].led_N_m = nullptr;
    if (std::exchange(state.arm[i].source, nullptr) != nullptr) parts.sources.scene.begin_at_tip(i);
  }
  state.guest = false;
}

void start_limits(Parts& parts) noexcept {
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = parts.state.arm[i];
    arm.force_N.setZero();
    arm.limits.start(max_force_N(parts, i), arm.posture.tip_m);
  }
}

void limit_forces(Parts& parts, const SourceOutcome& outcome) noexcept {
  State& state = parts.state;
  const float max_step_N = parts.params.get(Param::force_slew) * parts.setup.period_s;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    const Vec3& wanted_N = state.touch[i].force_N;
    const float ramp = arm.source != nullptr ? 1.0F : state.force_ramp;
    const bool rendered = arm.source == nullptr && state.source->needs().scene;
    const float wanted = wanted_N.norm();
    const float depth_m = rendered ? (state.touch[i].god_object_m - arm.posture.tip_m).norm() : 0.0F;
    const float max_N = arm.limits.max_N(max_force_N(parts, i), wanted, depth_m,
                                         kLimitSlew_N_s * parts.setup.period_s, parts.setup.period_s);
    const LimitedForce clamped = clamp_force(ramp * wanted_N, max_N);
    const Vec3& last_N = arm.probe.probes() ? arm.unprobed_N : arm.force_N;
    const Vec3 from_N = rendered ? remaining(last_N, clamped.value) : last_N;
    LimitedForce limited = slew_force(clamped.value, from_N, max_step_N);
    const Vec3 unramped_N = ramp < 1.0F ? clamp_force(wanted_N, max_N).value : clamped.value;
    const float paid = arm.limits.paid(arm.posture.tip_m, unramped_N, parts.setup.period_s);
    if (rendered && paid < 1.0F) {
      const LimitedForce part = clamp_force(limited.value, paid * std::min(wanted, max_N));
      limited = {part.value, limited.which || part.which};
    }
    // drive.cpp scales the torques of unprobed_N.
    if (arm.redundant) limited.value = faded(parts, i, limited.value);
    arm.unprobed_N = limited.value;
    limited.value = probed(parts, i, clamped.value, limited.value);
    if (!arm.redundant) limited.value = faded(parts, i, limited.value);
    arm.limits.add(unramped_N, limited.value, std::min(wanted / 2, max_N) * depth_m);
    arm.force_N = limited.value;
    const bool by_source = (outcome.clamped >> i & 1U) != 0;
    if (by_source || clamped.which) arm.limiters |= kLimitClamp;
    if (limited.which) arm.limiters |= kLimitSlew;
  }
}

// Brakes the tip, from whatever the force was: a stop does not wait for the slew limit.
void brake(Parts& parts) noexcept {
  State& state = parts.state;
  if (state.mode_time_s >= parts.params.get(Param::stop_time) || !slows(state, parts.setup.period_s)) {
    happen(parts, state.fault != Fault::kNone ? Event::kDampedByTrip : Event::kDamped);
    return;
  }
  const float damping_N_s_m = parts.params.get(Param::stop_damping);
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    ArmState& arm = state.arm[i];
    const LimitedForce clamped = clamp_force(-damping_N_s_m * arm.tip_velocity_m_s, max_force_N(parts, i));
    arm.force_N = faded(parts, i, clamped.value);
    if (clamped.which) arm.limiters |= kLimitClamp;
  }
}

}  // namespace thimble::firmware
