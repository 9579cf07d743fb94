#include <algorithm>
#include <cmath>
#include <cstdint>

#include "firmware/core/steps.h"

namespace thimble::firmware {
namespace {

// Ticks that take longer than a period leave no time to a background on the same core, which then hears no host. While one in five ends in
// time there is some, and it is a late tick that is only counted.
constexpr float kOverload_s = 0.1F, kInTime = 4.0F;
constexpr float kBeyondStops_rad = 0.05F;  // the give of an arm's stops, and more

void begin_tick(Parts& parts, const Inputs& inputs) noexcept {
  State& state = parts.state;
  if (inputs.tick != state.tick + 1) parts.observers.recorder.end(RecordingEnd::kTickLost);
  state.lost = state.first_tick || inputs.tick <= state.tick ? 0 : inputs.tick - state.tick - 1;
  state.first_tick = false;
  state.tick = inputs.tick;
  const auto periods = static_cast<std::uint32_t>(std::min<std::uint64_t>(state.lost, UINT32_MAX - 1)) + 1;
  state.mode_time_s += parts.setup.period_s * static_cast<float>(periods);
  for (ArmState& arm : state.arm) arm.limiters = 0;
}

// Whether the tick before took longer than a period, and most of those before it.
bool is_overloaded(Parts& parts, float last_tick_us, std::uint32_t lost) noexcept {
  State& state = parts.state;
  const float period_s = parts.setup.period_s;
  const bool longer = last_tick_us > period_s * 1e6F;
  if (longer) ++state.telemetry.overruns;
  state.overload_s += longer ? period_s * static_cast<float>(lost + 1U) : -kInTime * period_s;
  state.overload_s = motors_on(state.mode) ? std::max(state.overload_s, 0.0F) : 0.0F;
  return state.overload_s > kOverload_s;
}

void check_clock(Parts& parts, const Inputs& inputs, std::uint32_t lost) noexcept {
  Telemetry& telemetry = parts.state.telemetry;
  telemetry.lost_ticks += lost;
  if (is_overloaded(parts, inputs.last_tick_us, lost)) {
    trip(parts, Fault::tick_lost);
    parts.observers.recorder.end(RecordingEnd::kTickLost);  // no recording has how long a tick took
  }
  parts.observers.late_ticks.add(inputs.late_us);
  if (inputs.e_stop) trip(parts, Fault::e_stop);
  if (motors_on(parts.state.mode) && lost > parts.params.get_unsigned(Param::lost_ticks))
    trip(parts, Fault::tick_lost);
}

bool misses_host(const Parts& parts, const SourceNeeds& needs) noexcept {
  if (!needs.host) return false;
  return needs.host_timeout_s > 0 ? host_silence_s(parts) > needs.host_timeout_s : !parts.state.link_seen;
}

bool host_is_lost(const Parts& parts) noexcept {
  const State& state = parts.state;
  if (state.mode != Mode::kArmed) return false;
  if (!state.link_seen && parts.params.on(Param::host_supervision)) return true;
  if (misses_host(parts, state.source->needs())) return true;
  return state.guest && std::any_of(state.arm.begin(), state.arm.end(), [&](const ArmState& arm) {
           return arm.source != nullptr && misses_host(parts, arm.source->needs());
         });
}

void check_host(Parts& parts, std::uint32_t lost) noexcept {
  State& state = parts.state;
  const std::uint32_t stops = parts.commands.stops();
  state.stop_ordered = stops != state.stops_seen;
  state.stops_seen = stops;
  if (state.stop_ordered) trip(parts, Fault::host_stop);
  const std::uint32_t disarms = parts.commands.disarms();
  state.disarm_ordered = disarms != state.disarms_seen;
  state.disarms_seen = disarms;

  const std::uint32_t alive = parts.commands.alive();
  if (alive != state.alive_seen) {
    state.link_age_ticks = 0;
    state.link_seen = true;
  } else {
    state.link_age_ticks += std::min(lost + 1U, UINT32_MAX - state.link_age_ticks);
  }
  state.alive_seen = alive;
  if (host_silence_s(parts) > parts.params.get(Param::link_timeout)) {
    state.link_seen = false;
    parts.observers.recorder.end(RecordingEnd::kHostSilent);
  }
  if (host_is_lost(parts)) trip(parts, Fault::host_lost);
}

// By how much the torque of a joint may change while it does not count, and for how long. No hand holds an arm that moves by itself:
// whatever it presses on, the stretch of its cables gives counts once friction is overcome, but few in a slow move. Greater parameters
// than the defaults are for hands, and do not make a move's watch duller.
struct Frozen {
  float change_N_m, time_s;
};
struct FrozenParams {
  float part, time_s;  // part: of the joint's peak torque
};
Frozen frozen_limits(const Parts& parts, std::size_t index, std::size_t joint,
                     const FrozenParams& params) noexcept {
  const ArmState& arm = parts.state.arm[index];
  const JointConstants& constants = parts.setup.joint[index][joint];
  const Frozen held{params.part * constants.peak_N_m, params.time_s};
  if (arm.source == nullptr || arm.led_N_m != nullptr) return held;
  const float part = std::min(params.part, row_of(Param::encoder_frozen).initial);
  const float time_s = std::min(params.time_s, row_of(Param::encoder_frozen_time).initial);
  const float change_N_m = part * constants.peak_N_m;
  const float lever2_m2 = arm.posture.jacobian.col(static_cast<int>(joint)).squaredNorm();
  const float least_N_m = std::max(0.6F * change_N_m, constants.in_move.torque_N_m(lever2_m2));
  const float late_m = kMoveCounts * constants.count_rad * std::sqrt(lever2_m2);
  return {std::min(change_N_m, least_N_m), std::max(0.25F * time_s, late_m / parts.sources.move.speed_m_s())};
}

bool is_frozen(Parts& parts, std::size_t index, std::size_t joint, const FrozenParams& params) noexcept {
  ArmState& arm = parts.state.arm[index];
  const Frozen limits = frozen_limits(parts, index, joint, params);
  return arm.watch[joint].frozen(arm.encoder[joint].counts(), arm.torque_N_m[static_cast<int>(joint)],
                                 limits.change_N_m, limits.time_s, parts.setup.period_s);
}

// While armed: whether the arm can be where its counts say, and move as they say.
void check_motion(Parts& parts, ArmState& arm, const kinematics::Arm<float>& geometry) noexcept {
  if (parts.state.mode != Mode::kArmed) return;
  if (!arm.in_workspace && geometry.limit(arm.joint_rad, -kBeyondStops_rad) != 0) {
    trip(parts, Fault::joint_range);
    arm.homed = false;
  }
  if (arm.speed_watch.too_fast(arm.tip_velocity_m_s.norm(), arm.force_N,
                               parts.params.get(Param::max_tip_speed), parts.setup.period_s))
    trip(parts, Fault::tip_speed);
}

// Encoder counts to joints, tip and velocity.
void read_arm(Parts& parts, std::size_t index, const ArmInputs& input, std::uint64_t tick) noexcept {
  ArmState& arm = parts.state.arm[index];
  const kinematics::Arm<float>& geometry = parts.setup.arm[index];
  arm.age_ticks = tick - input.sample_tick;  // huge for a sample from the future: stale as well
  if (arm.age_ticks != 0) {
    ++parts.state.telemetry.stale_samples;
    parts.observers.recorder.end(RecordingEnd::kSampleStale);
  }
  const bool watched = arm.homed || parts.state.mode == Mode::kHoming;
  if (arm.age_ticks > stale_ticks(parts)) {
    if (watched) trip(parts, Fault::encoder_stale);
    lose_home(arm);
    return;
  }
  if (arm.seen && input.sample_tick == arm.sample_tick) return;
  const std::uint64_t passed = input.sample_tick > arm.sample_tick ? input.sample_tick - arm.sample_tick : 1;
  const auto periods = static_cast<std::uint32_t>(arm.seen ? std::min<std::uint64_t>(passed, UINT32_MAX) : 1);
  arm.sample_tick = input.sample_tick;
  const FrozenParams frozen{parts.params.get(Param::encoder_frozen),
                            parts.params.get(Param::encoder_frozen_time)};
  Axes joint_speed;
  const std::size_t axes = arm.axes;
  const bool armed = parts.state.mode == Mode::kArmed;
  for (std::size_t j = 0; j < axes; ++j) {
    const int axis = static_cast<int>(j);
    kinematics::JointEncoder& encoder = arm.encoder[j];
    if (!arm.seen) {
      encoder.home(input.counts[j], geometry.home()[axis]);
      arm.speed[j].reset(0);
    } else if (encoder.update(input.counts[j], periods) != kinematics::EncoderStatus::kOk) {
      if (watched) trip(parts, Fault::encoder_jump);
      lose_home(arm);
      return;
    }
    arm.joint_rad[axis] = encoder.angle_rad();
    joint_speed[axis] = arm.speed[j].update(encoder.counts(), periods) * encoder.rad_per_count();
    arm.suspect[j] = armed && is_frozen(parts, index, j, frozen);
    // Torques of the axes that follow no place end by their time, and whether an axis moves is what they find out.
    const bool proves = arm.led_N_m == nullptr ? arm.source != nullptr : parts.sources.axes.follows();
    if (arm.suspect[j] && proves) {
      trip(parts, Fault::encoder_frozen);
      arm.homed = false;
    }
  }
  arm.seen = true;
  geometry.move_to(arm.joint_rad, arm.posture);
  arm.tip_velocity_m_s = kinematics::velocity(arm.posture.jacobian, joint_speed, geometry.axes());
  arm.in_workspace = geometry.limit(arm.joint_rad) == 0;
  if (arm.homed && !(finite(arm.posture.tip_m) && finite(arm.tip_velocity_m_s))) {
    trip(parts, Fault::tip_not_finite);
    arm.homed = false;
  }
  check_motion(parts, arm, geometry);
}

void heat_motors(Parts& parts, std::size_t index, const ArmEvidence& evidence, std::uint32_t lost) noexcept {
  ArmState& arm = parts.state.arm[index];
  const float ambient_C = parts.params.get(Param::ambient);
  const float winding_limit_C = parts.params.get(Param::winding_limit);
  const float time_s = parts.setup.period_s * static_cast<float>(lost + 1U);
  const kinematics::ArmData& data = parts.setup.arm[index].data();
  const std::size_t axes = arm.axes;
  for (std::size_t j = 0; j < axes; ++j) {
    if (!data.geometry.driven[j]) continue;
    const kinematics::MotorModel& motor = data.axis[j].motor;
    const float limit_C = std::min(winding_limit_C, motor.max_winding_C);
    arm.heat[j].add(motor, arm.current_A[static_cast<int>(j)], ambient_C, time_s);
    if (arm.heat[j].winding_C(ambient_C) > limit_C || evidence.motor_C[j] > limit_C)
      trip(parts, Fault::motor_hot);
  }
}

// What the background has learned of the time off.
void cool_motors(Parts& parts) noexcept {
  MotorsHeat less;
  if (!parts.heat.less.read(less)) return;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i)
    for (std::size_t j = 0; j < parts.state.arm[i].axes; ++j) parts.state.arm[i].heat[j].take_off(less[i][j]);
}

void show_heat(Parts& parts) noexcept {
  MotorsHeat now;
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i)
    for (std::size_t j = 0; j < kJoints; ++j) now[i][j] = parts.state.arm[i].heat[j].heat();
  parts.heat.now.write(now);
}

// The time off waits while a recording runs: a replay has only what the recording began with.
void exchange_heat(Parts& parts, std::uint32_t lost) noexcept {
  State& state = parts.state;
  if (!parts.observers.recorder.running() && parts.heat.less.written()) cool_motors(parts);
  state.heat_shown_s += parts.setup.period_s * static_cast<float>(lost + 1U);
  if (state.heat_shown_s < HeatExchange::kInterval_s) return;
  state.heat_shown_s = 0;
  show_heat(parts);
}

}  // namespace

void sense(Parts& parts, const Inputs& inputs) noexcept {
  begin_tick(parts, inputs);
  if (parts.setup.arm_count == 0) return;
  const auto lost = static_cast<std::uint32_t>(std::min<std::uint64_t>(parts.state.lost, UINT32_MAX - 1));
  check_clock(parts, inputs, lost);
  check_host(parts, lost);
  for (std::size_t i = 0; i < parts.setup.arm_count; ++i) {
    check_evidence(parts, i, inputs.arm[i]);
    heat_motors(parts, i, inputs.arm[i].evidence, lost);
    read_arm(parts, i, inputs.arm[i], inputs.tick);
    check_index(parts, i, inputs.arm[i]);
  }
  exchange_heat(parts, lost);
}

}  // namespace thimble::firmware
