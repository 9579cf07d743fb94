#include "firmware/servo.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/limits.h"
#include "kinematics/dynamics.h"
#include "kinematics/motor_current.h"

namespace thimble::firmware {
namespace {

constexpr float kRampUp_s = 0.2F;     // after arming and after a scene swap
constexpr float kRampDown_s = 0.05F;  // before a scene swap
constexpr float kMinPeriod_s = 40e-6F;
constexpr float kMaxPeriod_s = 20e-3F;
constexpr float kWorkspaceMargin_rad = 0.05F;  // of a move's target
constexpr std::uint32_t kSerialShift = 8;      // of command_

bool finite(const Vec3& v) noexcept {
  return std::isfinite(v.squaredNorm());
}  // squared: what the clamp works with

const kinematics::ArmModel& model_or_first(const char* name) noexcept {
  const kinematics::ArmModel* model = kinematics::find_arm_model(name);
  return model != nullptr ? *model : kinematics::arm_models().front();
}

link::Levels levels(const Inputs& inputs, std::size_t arms) noexcept {
  link::Levels levels;
  levels.dead_man = inputs.dead_man;
  levels.e_stop = inputs.e_stop;
  for (std::size_t i = 0; i < arms; ++i) {
    levels.index[i] = inputs.arm[i].index;
    levels.drive_fault[i] = inputs.arm[i].drive_fault;
  }
  return levels;
}

bool config_works(const Config& config) noexcept {
  if (config.arm_count < 1 || config.arm_count > kMaxArms) return false;
  if (!(config.period_s >= kMinPeriod_s && config.period_s <= kMaxPeriod_s)) return false;
  if (config.node_id < 1 || config.node_id > 127) return false;
  return std::all_of(config.arm.begin(), config.arm.begin() + config.arm_count,
                     [](const ArmConfig& arm) { return kinematics::find_arm_model(arm.model) != nullptr; });
}

}  // namespace

Servo::ArmState::ArmState(const ArmConfig& config, float period_s) noexcept
    : arm(model_or_first(config.model), config.base), has_index(config.has_index) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    encoder[j] = kinematics::JointEncoder(arm.model(), static_cast<int>(j), period_s);
    speed[j] = kinematics::VelocityEstimator(period_s);
  }
  joint_rad = arm.home();
  posture = arm.at(joint_rad);
}

Servo::Servo(const Config& config, const Params& params) noexcept
    : params_(params),
      board_lacks_(config.lacks != nullptr && *config.lacks != '\0'),
      period_s_(config_works(config) ? config.period_s : kMaxPeriod_s),
      arm_count_(config_works(config) ? config.arm_count : std::uint8_t{0}),
      arms_{ArmState(config.arm[0], period_s_), ArmState(config.arm[1], period_s_)},
      host_forces_(period_s_),
      published_unmet_(kNotHomed | kEncoderStale | kNoScene) {
  if (arm_count_ != 0) return;
  trip(Fault::bad_config);
  published_mode_.store(mode_, std::memory_order_release);
  published_fault_.store(fault_, std::memory_order_release);
  published_unmet_.store(kBadConfig | kFaultLatched, std::memory_order_release);
}

// ---------------------------------------------------------------------------------------------------- the
// tick

Outputs Servo::tick(const Inputs& inputs) noexcept {
  const std::uint32_t command = command_.load(std::memory_order_acquire);
  const bool new_command = command >> kSerialShift != command_done_.load(std::memory_order_relaxed);

  if (inputs.tick != tick_ + 1) trace_.end(TraceEnd::kTickLost);
  lost_ = first_tick_ || inputs.tick <= tick_ ? 0 : inputs.tick - tick_ - 1;
  first_tick_ = false;
  tick_ = inputs.tick;
  dead_man_ = inputs.dead_man;
  mode_time_s_ += period_s_;
  for (ArmState& arm : arms_) arm.limiters = 0;

  const std::uint32_t stops_before = stops_seen_;
  check_inputs(inputs);
  home_arms(inputs);
  const Conditions unmet = conditions(inputs);
  Command obeyed = stops_seen_ != stops_before ? Command::kStop : Command::kNone;
  if (new_command) {
    const Mode before = mode_;
    obey(static_cast<Command>(command & 0xFFU), unmet);
    if (mode_ != before) obeyed = static_cast<Command>(command & 0xFFU);  // without, it had no effect
  }
  if (mode_ == Mode::kArmed && !dead_man_) stop();
  switch_scene();

  if (mode_ == Mode::kArmed) render();
  if (mode_ == Mode::kDamping) damp();  // also right after a trip in render()
  if (mode_ != Mode::kArmed) move_.stop();
  Outputs outputs;
  drive(outputs);
  outputs.mode = mode_;

  show(inputs);
  if (trace_.running()) {
    trace_tick(inputs, obeyed);
  } else if (new_command && static_cast<Command>(command & 0xFFU) == Command::kTrace) {
    start_trace(inputs);
  }
  if (new_command) command_done_.store(command >> kSerialShift, std::memory_order_release);
  return outputs;
}

// For an arm that moves by itself a host must be near.
bool Servo::unattended() const noexcept {
  return static_cast<float>(link_age_ticks_) * period_s_ > link::kMoveHostTimeout_s;
}

bool Servo::homed() const noexcept {
  return arm_count_ != 0 && std::all_of(arms_.begin(), arms_.begin() + arm_count_,
                                        [](const ArmState& arm) { return arm.homed; });
}

// The one way into a fault. The motors brake or go to zero in this very tick.
void Servo::trip(Fault reason) noexcept {
  const FaultRow* row = find_fault(reason);
  faults_seen_.store(faults_seen_.load(std::memory_order_relaxed) | 1U << static_cast<unsigned>(reason),
                     std::memory_order_release);
  const bool zero = row == nullptr || row->reaction == Reaction::kZero;
  if (fault_ == Fault::kNone) {
    fault_ = reason;
    fault_tick_.store(static_cast<std::uint32_t>(tick_), std::memory_order_release);
    ++telemetry_.trips;
    if (mode_ == Mode::kArmed) mode_time_s_ = 0;
    mode_ = motors_on() && !zero ? Mode::kDamping : Mode::kFaulted;
  } else if (zero) {
    mode_ = Mode::kFaulted;  // what was braking can't be trusted any more
  }
}

void Servo::stop() noexcept {
  mode_ = Mode::kDamping;
  mode_time_s_ = 0;
}

void Servo::check_inputs(const Inputs& inputs) noexcept {
  if (arm_count_ == 0) return;
  const auto lost = static_cast<std::uint32_t>(std::min<std::uint64_t>(lost_, UINT32_MAX));
  telemetry_.lost_ticks += lost;
  if (inputs.last_tick_us > period_s_ * 1e6F) ++telemetry_.overruns;
  const auto* const bound = std::upper_bound(kLateBounds_us.begin(), kLateBounds_us.end(), inputs.late_us);
  std::atomic<std::uint32_t>& late = late_ticks_[static_cast<std::size_t>(bound - kLateBounds_us.begin())];
  late.store(late.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);  // one writer
  if (inputs.late_us > worst_late_us_.load(std::memory_order_relaxed))
    worst_late_us_.store(inputs.late_us, std::memory_order_relaxed);
  if (inputs.e_stop) trip(Fault::e_stop);
  if (motors_on() && lost > params_.get_unsigned(Param::lost_ticks)) trip(Fault::tick_lost);

  const std::uint32_t stops = stop_requests_.load(std::memory_order_acquire);
  if (stops != stops_seen_) trip(Fault::host_stop);
  stops_seen_ = stops;

  const std::uint32_t alive = alive_.load(std::memory_order_acquire);
  if (alive != alive_seen_) {
    link_age_ticks_ = 0;
    link_seen_ = true;
  } else {
    link_age_ticks_ += std::min(lost + 1U, UINT32_MAX - link_age_ticks_);
  }
  alive_seen_ = alive;
  if (static_cast<float>(link_age_ticks_) * period_s_ > params_.get(Param::link_timeout)) {
    link_seen_ = false;
    trace_.end(TraceEnd::kHostSilent);
  }
  const bool supervised = !link_seen_ && (host_renders_ || params_.on(Param::host_supervision));
  if (mode_ == Mode::kArmed && (supervised || (move_.active() && unattended()))) trip(Fault::host_lost);

  const float ambient_C = params_.get(Param::ambient);
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    if (inputs.arm[i].drive_fault) trip(Fault::drive_fault);
    const kinematics::MotorModel& motor = arm.arm.model().motor;
    const float limit_C = std::min(params_.get(Param::winding_limit), motor.max_winding_C);
    for (std::size_t j = 0; j < kJoints; ++j) {
      arm.heat[j].add(motor, arm.current_A[static_cast<int>(j)], ambient_C,
                      period_s_ * static_cast<float>(lost + 1U));
      if (arm.heat[j].winding_C(ambient_C) > limit_C) trip(Fault::motor_hot);
    }
    read_arm(arm, inputs.arm[i], inputs.tick);
  }
}

// Encoder counts to joints, tip and velocity. An encoder fault costs the home reference.
void Servo::read_arm(ArmState& arm, const ArmInputs& input, std::uint64_t tick) noexcept {
  arm.age_ticks = tick - input.sample_tick;  // huge for a sample from the future: stale as well
  if (arm.age_ticks != 0) {
    ++telemetry_.stale_samples;
    trace_.end(TraceEnd::kSampleStale);
  }
  const bool watched = arm.homed || mode_ == Mode::kHoming;
  if (arm.age_ticks > params_.get_unsigned(Param::encoder_stale_ticks)) {
    if (watched) trip(Fault::encoder_stale);
    arm.homed = false;
    arm.seen = false;
    return;
  }
  if (arm.seen && input.sample_tick == arm.sample_tick) return;
  arm.sample_tick = input.sample_tick;
  Vec3 joint_speed;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const int axis = static_cast<int>(j);
    kinematics::JointEncoder& encoder = arm.encoder[j];
    if (!arm.seen) {
      encoder.home(input.counts[j], arm.arm.home()[axis]);
      arm.speed[j].reset(0);
    } else if (encoder.update(input.counts[j]) != kinematics::EncoderStatus::kOk) {
      if (watched) trip(Fault::encoder_jump);
      arm.homed = false;
      arm.seen = false;
      return;
    }
    arm.joint_rad[axis] = encoder.angle_rad();
    joint_speed[axis] = arm.speed[j].update(encoder.counts()) * encoder.rad_per_count();
    const float peak_N_m =
        std::abs(arm.arm.model().torque_per_ampere(axis)) * arm.arm.model().motor.peak_current_A;
    if (mode_ == Mode::kArmed && arm.watch[j].frozen(encoder.counts(), arm.torque_N_m[axis],
                                                     params_.get(Param::encoder_frozen) * peak_N_m,
                                                     params_.get(Param::encoder_frozen_time), period_s_)) {
      trip(Fault::encoder_frozen);
      arm.homed = false;
    }
  }
  arm.seen = true;
  arm.posture = arm.arm.at(arm.joint_rad);
  arm.tip_velocity_m_s = arm.posture.jacobian * joint_speed;
  arm.in_workspace =
      kinematics::workspace_limit(arm.arm.model(), arm.joint_rad) == kinematics::WorkspaceLimit::kNone;
  if (arm.homed && !(finite(arm.posture.tip_m) && finite(arm.tip_velocity_m_s))) {
    trip(Fault::tip_not_finite);
    arm.homed = false;
  }
}

void Servo::home_arms(const Inputs& inputs) noexcept {
  if (mode_ != Mode::kHoming) return;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    const ArmInputs& input = inputs.arm[i];
    if (arm.homed || arm.age_ticks != 0 || (arm.has_index && !input.index)) continue;
    for (std::size_t j = 0; j < kJoints; ++j) {
      arm.encoder[j].home(input.counts[j], arm.arm.home()[static_cast<int>(j)]);
      arm.speed[j].reset(0);
    }
    arm.joint_rad = arm.arm.home();
    arm.posture = arm.arm.at(arm.joint_rad);
    arm.tip_velocity_m_s.setZero();
    arm.in_workspace = true;
    arm.homed = true;
  }
  if (homed()) {
    mode_ = Mode::kReady;
  } else if (mode_time_s_ > params_.get(Param::homing_timeout)) {
    trip(Fault::homing_timeout);
  }
}

Conditions Servo::conditions(const Inputs& inputs) const noexcept {
  if (arm_count_ == 0) return kBadConfig | kFaultLatched;
  unsigned unmet = 0;
  if (!homed()) unmet |= kNotHomed;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    const ArmState& arm = arms_[i];
    if (arm.age_ticks > params_.get_unsigned(Param::encoder_stale_ticks)) unmet |= kEncoderStale;
    if (arm.homed && !arm.in_workspace) unmet |= kOutsideWorkspace;
    if (inputs.arm[i].drive_fault) unmet |= kDriveFault;
  }
  if (fault_ != Fault::kNone) unmet |= kFaultLatched;
  if (!inputs.dead_man) unmet |= kDeadManOpen;
  if (sequence_ == 0 && !params_.on(Param::host_forces)) unmet |= kNoScene;
  if (!link_seen_) unmet |= kLinkDown;
  if (inputs.e_stop) unmet |= kEStopPressed;
  if (board_lacks_) unmet |= kBoardLacks;
  if (mode_ == Mode::kHoming || mode_ == Mode::kDamping) unmet |= kWrongMode;
  return static_cast<Conditions>(unmet);
}

Conditions Servo::move_conditions(Conditions unmet) const noexcept {
  if (arm_count_ == 0) return unmet;
  unsigned against = unmet & ~static_cast<unsigned>(kDeadManOpen);  // an open dead-man has disarmed
  if (mode_ != Mode::kArmed) against |= kNotArmed;
  if (!params_.on(Param::allow_moves)) against |= kMovesNotAllowed;
  if (params_.on(Param::host_forces)) against |= kHostRenders;
  if (unattended()) against |= kLinkDown;
  if (mode_ == Mode::kArmed && force_ramp_ < 1.0F && !move_.active()) against |= kRampRuns;
  if (move_.under_way()) against |= kMoveUnderWay;
  if (!move_.active() && std::any_of(touches_.begin(), touches_.begin() + arm_count_,
                                     [](const control::Touch& touch) { return touch.contacts != 0; }))
    against |= kInContact;
  return static_cast<Conditions>(against);
}

void Servo::obey(Command command, Conditions unmet) noexcept {
  switch (command) {
    case Command::kHome:
      if (mode_ != Mode::kDisarmed && mode_ != Mode::kReady) return;
      for (ArmState& arm : arms_) arm.homed = false;
      mode_ = Mode::kHoming;
      mode_time_s_ = 0;
      return;
    case Command::kArm:
      if (mode_ != Mode::kReady || unmet != 0) return;
      mode_ = Mode::kArmed;
      force_ramp_ = gravity_ramp_ = 0;
      host_renders_ = params_.on(Param::host_forces);
      if (host_renders_) trace_.end(TraceEnd::kHostForces);
      host_forces_.forget();
      renderer_.reset();
      for (ArmState& arm : arms_) {
        arm.force_N.setZero();
        for (EncoderWatch& watch : arm.watch) watch.reset();
      }
      return;
    case Command::kDisarm:
      if (mode_ == Mode::kArmed) stop();
      if (mode_ == Mode::kHoming) mode_ = Mode::kDisarmed;
      return;
    case Command::kClear:
      if (mode_ != Mode::kFaulted || (unmet & (kEStopPressed | kDriveFault | kBadConfig)) != 0) return;
      fault_ = Fault::kNone;
      faults_seen_.store(0, std::memory_order_release);
      freeze_count_ = 0;
      frozen_.store(false, std::memory_order_release);
      mode_ = homed() ? Mode::kReady : Mode::kDisarmed;
      return;
    case Command::kMove: {
      if (move_conditions(unmet) != 0) return;
      trace_.end(TraceEnd::kGuardedMove);
      const ArmState& arm = arms_[posted_move_.arm];
      move_.start(posted_move_, arm.arm, arm.posture.tip_m);
      return;
    }
    case Command::kEndMove:
      if (!move_.active()) return;
      move_.stop();
      force_ramp_ = 0;  // the scene's force comes back as after arming
      return;
    case Command::kNone:
    case Command::kStop:   // comes through stop_requests_
    case Command::kTrace:  // at the end of the tick
      return;
  }
}

// Takes the scene that the background posted. While armed the old one fades out first and the new one in; what the host orders
// has nothing to do with either.
void Servo::switch_scene() noexcept {
  const std::uint32_t posted = scene_posted_.load(std::memory_order_acquire);
  const bool waiting = posted != scene_taken_.load(std::memory_order_relaxed);
  if (waiting) trace_.end(TraceEnd::kScene);
  if (mode_ == Mode::kArmed) {
    const bool fades = waiting && !host_renders_;
    const float step = fades ? -period_s_ / kRampDown_s : period_s_ / kRampUp_s;
    force_ramp_ = std::clamp(force_ramp_ + step, 0.0F, 1.0F);
    if (fades && force_ramp_ > 0.0F) return;
  }
  if (!waiting) return;
  renderer_.bind(posted_scene_, posted_binding_);
  take_scene(posted);
}

void Servo::take_scene(std::uint32_t posted) noexcept {
  scene_ = posted_scene_;
  sequence_ = posted_sequence_;
  telemetry_.contact_ticks = 0;
  telemetry_.peak_force_N = 0;
  telemetry_.mean_force_N = 0;
  scene_taken_.store(posted, std::memory_order_release);
}

// Everything that outlives a tick goes into the start record, or is put back to where it starts.
void Servo::start_trace(const Inputs& inputs) noexcept {
  const bool at_rest = mode_ == Mode::kDisarmed || mode_ == Mode::kReady;
  const bool scene_waits =
      scene_posted_.load(std::memory_order_acquire) != scene_taken_.load(std::memory_order_relaxed);
  if (!at_rest || fault_ != Fault::kNone || sequence_ == 0 || scene_waits || arm_count_ == 0) return;
  TraceArms arms;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    const ArmState& arm = arms_[i];
    if (!arm.seen || arm.age_ticks != 0) return;
    link::TraceArm& to = arms[i];
    to.homed = arm.homed;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const MotorHeat::State heat = arm.heat[j].state();
      to.raw[j] = arm.encoder[j].raw();
      to.counts[j] = arm.encoder[j].counts();
      to.winding_K[j] = heat.winding_K;
      to.housing_K[j] = heat.housing_K;
      to.charge_A2_s[j] = heat.charge_A2_s;
      to.time_s[j] = heat.time_s;
    }
  }
  link::TraceStart start;
  start.tick = static_cast<std::uint32_t>(tick_);
  start.period_s = period_s_;
  start.mode = mode_;
  start.levels = levels(inputs, arm_count_);
  start.arms = arm_count_;
  settle(start, arms);
  trace_.begin(start, arms);
}

void Servo::settle(const link::TraceStart& start, const TraceArms& arms) noexcept {
  renderer_.bind(scene_);
  touches_ = {};
  mode_ = start.mode == Mode::kReady ? Mode::kReady : Mode::kDisarmed;
  mode_time_s_ = force_ramp_ = gravity_ramp_ = 0;
  link_age_ticks_ = 0;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    const link::TraceArm& from = arms[i];
    for (std::size_t j = 0; j < kJoints; ++j) {
      const auto axis = static_cast<int>(j);
      arm.encoder[j].resume(from.raw[j], from.counts[j], arm.arm.home()[axis]);
      arm.speed[j].reset(from.counts[j]);
      arm.watch[j].reset();
      arm.heat[j].resume({from.winding_K[j], from.housing_K[j], from.charge_A2_s[j], from.time_s[j]});
      arm.joint_rad[axis] = arm.encoder[j].angle_rad();
    }
    arm.seen = true;
    arm.homed = from.homed;
    arm.sample_tick = tick_;
    arm.age_ticks = 0;
    arm.posture = arm.arm.at(arm.joint_rad);
    arm.in_workspace =
        kinematics::workspace_limit(arm.arm.model(), arm.joint_rad) == kinematics::WorkspaceLimit::kNone;
    arm.tip_velocity_m_s.setZero();
    arm.force_N.setZero();
    arm.torque_N_m.setZero();
    arm.current_A.setZero();
  }
}

void Servo::resume(const link::TraceStart& start, const TraceArms& arms) noexcept {
  take_scene(scene_posted_.load(std::memory_order_acquire));
  tick_ = start.tick;
  first_tick_ = false;
  settle(start, arms);
}

void Servo::trace_tick(const Inputs& inputs, Command obeyed) noexcept {
  Trace::Tick tick;
  tick.tick = inputs.tick;
  tick.arms = arm_count_;
  std::array<float, 3 * kMaxArms> forces_N{};
  for (std::size_t i = 0; i < kMaxArms; ++i) {
    tick.counts[i] = inputs.arm[i].counts;
    tick.wide[i] = arms_[i].arm.model().counter_width == kinematics::CounterWidth::k32;
    std::copy_n(arms_[i].force_N.data(), 3, forces_N.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  tick.forces = std::as_bytes(std::span(forces_N).first(std::size_t{3} * arm_count_));
  tick.mode = mode_;
  tick.command = static_cast<link::TracedCommand>(obeyed);
  tick.levels = levels(inputs, arm_count_);
  tick.faulted = fault_ != Fault::kNone;
  trace_.tick(tick);
}

void Servo::render() noexcept {
  if (host_renders_) {
    feel_orders();
  } else {
    std::array<control::Tip, kMaxArms> tips;
    for (std::size_t i = 0; i < arm_count_; ++i)
      tips[i] = {arms_[i].posture.tip_m, arms_[i].tip_velocity_m_s};
    renderer_.tick(std::span(tips).first(arm_count_), period_s_, std::span(touches_).first(arm_count_));
  }

  gravity_ramp_ = std::min(gravity_ramp_ + period_s_ / kRampUp_s, 1.0F);
  const float max_step_N = params_.get(Param::force_slew) * period_s_;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    if (!finite(touches_[i].force_N)) {
      touches_[i] = {};
      trip(Fault::force_not_finite);
      return;
    }
    const bool moves = move_.active() && move_.arm() == i;
    const LimitedForce wanted =
        moves ? move_.tick(arm.arm, arm.posture, arm.tip_velocity_m_s, arm.force_N, period_s_)
              : LimitedForce{touches_[i].force_N * force_ramp_, false};
    if (!finite(wanted.value)) {
      trip(Fault::force_not_finite);
      return;
    }
    if (moves && (!move_.active() || !arm.in_workspace)) {
      stop();
      return;
    }
    const float max_N = std::min(params_.get(Param::max_force), arm.arm.model().max_force_N);
    const LimitedForce clamped = clamp_force(wanted.value, max_N);
    const LimitedForce slewed = slew_force(clamped.value, arm.force_N, max_step_N);
    const LimitedForce last = clamp_force(slewed.value, max_N);  // acts only just after max_force was lowered
    arm.force_N = last.value;
    if (wanted.which || clamped.which || last.which) arm.limiters |= kLimitClamp;
    if (slewed.which) arm.limiters |= kLimitSlew;
  }
}

// What the host orders stands where the scene's forces do, so that ramp, clamp, slew and the motors' limits are the same. Without an
// order that is in force the tip is damped.
void Servo::feel_orders() noexcept {
  const float damping_N_s_m = params_.get(Param::stop_damping);
  for (std::size_t i = 0; i < arm_count_; ++i) {
    const Vec3* ordered_N = host_forces_.take(i, tick_);
    touches_[i].god_object_m = arms_[i].posture.tip_m;
    touches_[i].force_N =
        ordered_N != nullptr ? *ordered_N : Vec3(-damping_N_s_m * arms_[i].tip_velocity_m_s);
    touches_[i].contacts = 0;
  }
}

// Brakes the tip, from wherever the force was: a stop does not wait for the slew limit.
void Servo::damp() noexcept {
  if (mode_time_s_ >= params_.get(Param::stop_time)) {
    mode_ = fault_ != Fault::kNone ? Mode::kFaulted : homed() ? Mode::kReady : Mode::kDisarmed;
    return;
  }
  const float damping_N_s_m = params_.get(Param::stop_damping);
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    const float max_N = std::min(params_.get(Param::max_force), arm.arm.model().max_force_N);
    const LimitedForce clamped = clamp_force(-damping_N_s_m * arm.tip_velocity_m_s, max_N);
    arm.force_N = clamped.value;
    if (clamped.which) arm.limiters |= kLimitClamp;
  }
}

// Forces to joint torques to currents; zero unless the motors are on.
void Servo::drive(Outputs& outputs) noexcept {
  const bool carry_weight = params_.on(Param::gravity_compensation);
  const float ambient_C = params_.get(Param::ambient);
  for (std::size_t i = 0; i < arm_count_ && motors_on(); ++i) {
    ArmState& arm = arms_[i];
    const kinematics::ArmModel& model = arm.arm.model();
    arm.torque_N_m = arm.posture.jacobian.transpose() * arm.force_N;
    if (carry_weight)
      arm.torque_N_m += gravity_ramp_ * kinematics::gravity_torques(model.inertia, arm.posture);
    if (!finite(arm.torque_N_m)) {
      trip(Fault::torque_not_finite);
      break;
    }
    const float limit_C = std::min(params_.get(Param::winding_limit), model.motor.max_winding_C);
    Vec3 limit_A;
    bool derated = false;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const float allowed = arm.heat[j].allowed(ambient_C, limit_C);
      limit_A[static_cast<int>(j)] = allowed * model.motor.peak_current_A;
      derated = derated || allowed < 1.0F;
    }
    const auto currents = kinematics::motor_currents(model, arm.torque_N_m, limit_A);
    if (!finite(currents.value)) {
      trip(Fault::torque_not_finite);
      break;
    }
    arm.current_A = currents.value;
    if (currents.which != kinematics::CurrentLimit::kNone) {
      // All torques were scaled alike, so the force was too.
      const int limiting = static_cast<int>(currents.which) - 1;
      const float wanted_A = arm.torque_N_m[limiting] / model.torque_per_ampere(limiting);
      const float scale = currents.value[limiting] / wanted_A;
      arm.force_N *= scale;
      arm.torque_N_m *= scale;
      arm.limiters |=
          derated && limit_A[limiting] < model.motor.peak_current_A ? kLimitThermal : kLimitCurrent;
    }
  }
  for (std::size_t i = 0; i < arm_count_; ++i) {
    ArmState& arm = arms_[i];
    if (motors_on()) {
      for (std::size_t j = 0; j < kJoints; ++j)
        outputs.arm[i].current_A[j] = arm.current_A[static_cast<int>(j)];
      outputs.arm[i].enable = true;
    } else {
      arm.force_N.setZero();
      arm.torque_N_m.setZero();
      arm.current_A.setZero();
    }
  }
}

// ----------------------------------------------------------------------------------------------------
// telemetry

void Servo::show(const Inputs& inputs) noexcept {
  const float ambient_C = params_.get(Param::ambient);
  const Conditions unmet = conditions(inputs);
  Telemetry& t = telemetry_;
  t.tick = inputs.tick;
  t.time_us = inputs.time_us;
  t.tick_us = inputs.last_tick_us;
  t.worst_tick_us = std::max(t.worst_tick_us, inputs.last_tick_us);
  t.mode = mode_;
  t.fault = fault_;
  t.ramp = mode_ == Mode::kArmed ? force_ramp_ : 0.0F;
  t.unmet = unmet;
  t.arm_count = arm_count_;
  t.moves_itself = move_.active();
  t.scene_sequence = sequence_;
  t.sweep_bound = renderer_.counters().sweep_bound;
  t.slide_bound = renderer_.counters().slide_bound;
  bool contact = false;
  float most_N = 0;
  for (std::size_t i = 0; i < arm_count_; ++i) {
    const ArmState& arm = arms_[i];
    ArmTelemetry& a = t.arm[i];
    const bool moves = move_.active() && move_.arm() == i;
    const bool touching = mode_ == Mode::kArmed && !moves;
    a.tip_m = arm.posture.tip_m;
    a.tip_velocity_m_s = arm.tip_velocity_m_s;
    a.god_object_m = touching ? touches_[i].god_object_m : moves ? move_.set_point_m() : a.tip_m;
    a.rendered_N = touching ? touches_[i].force_N : Vec3::Zero();
    a.contacts = touching ? touches_[i].contacts : std::uint8_t{0};
    a.force_N = arm.force_N;
    a.joint_rad = arm.joint_rad;
    a.current_A = arm.current_A;
    a.counts = inputs.arm[i].counts;
    a.winding_C = 0;
    for (std::size_t j = 0; j < kJoints; ++j)
      a.winding_C = std::max(a.winding_C, arm.heat[j].winding_C(ambient_C));
    a.limiters = arm.limiters;
    contact = contact || a.contacts != 0;
    const float force_N = std::sqrt(a.force_N.squaredNorm());
    if (touching) t.peak_force_N = std::max(t.peak_force_N, force_N);
    if (a.contacts != 0) most_N = std::max(most_N, force_N);
    record_limiters_[i] |= arm.limiters;
  }
  if (contact) t.mean_force_N += (most_N - t.mean_force_N) / static_cast<float>(++t.contact_ticks);
  record_tick_us_ = std::max(record_tick_us_, inputs.last_tick_us);

  if (!frozen_.load(std::memory_order_relaxed)) {
    freeze_[freeze_count_++ % kFreezeTicks] = t;
    if (freeze_count_ == 2 * kFreezeTicks) freeze_count_ = kFreezeTicks;
    if (fault_ != Fault::kNone) frozen_.store(true, std::memory_order_release);
  }

  if (++since_record_ >= params_.get_unsigned(Param::telemetry_decimation)) {
    since_record_ = 0;
    const std::uint32_t head = record_head_.load(std::memory_order_relaxed);
    if (head - record_tail_.load(std::memory_order_acquire) < kRecords) {
      Telemetry& record = records_[head % kRecords];
      record = t;
      record.tick_us = record_tick_us_;
      for (std::size_t i = 0; i < arm_count_; ++i) record.arm[i].limiters = record_limiters_[i];
      record_head_.store(head + 1, std::memory_order_release);
      record_limiters_ = {};
      record_tick_us_ = 0;
    } else {
      ++t.records_dropped;
    }
    if (!host_renders_ || mode_ != Mode::kArmed) show_scene();
  }

  published_fault_.store(fault_, std::memory_order_release);
  published_unmet_.store(unmet, std::memory_order_release);
  published_unmet_for_move_.store(move_conditions(unmet), std::memory_order_release);
  published_move_end_.store(move_.end(), std::memory_order_release);
  published_move_phase_.store(move_.state(), std::memory_order_release);
  published_mode_.store(mode_, std::memory_order_release);
}

void Servo::show_scene() noexcept {
  if (scene_state_full_.load(std::memory_order_acquire)) return;
  const std::span<const control::BodyState> bodies = renderer_.bodies();
  std::copy(bodies.begin(), bodies.end(), scene_state_.bodies.begin());
  scene_state_.body_count = bodies.size();
  scene_state_.tissue_count = renderer_.show_tissue(scene_state_.tissues);
  std::size_t planes = 0;
  for (std::size_t arm = 0; arm < arm_count_; ++arm) {
    const std::size_t count =
        telemetry_.arm[arm].contacts != 0 ? renderer_.show_planes(arm, scene_state_.planes[arm]) : 0;
    scene_state_.plane_count[arm] = static_cast<std::uint8_t>(count);
    planes += count;
  }
  if (scene_state_.body_count + scene_state_.tissue_count + planes != 0)
    scene_state_full_.store(true, std::memory_order_release);
}

// ----------------------------------------------------------------------------------------------------
// background

Conditions Servo::request(Command command) noexcept {
  const Mode now = mode();
  const Conditions against = unmet();
  unsigned refused = 0;
  switch (command) {
    case Command::kNone:
      return 0;
    case Command::kStop:
      stop_requests_.store(stop_requests_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
      return 0;
    case Command::kDisarm:
    case Command::kEndMove:
      break;
    case Command::kMove:
      return kWrongMode;  // without an order
    case Command::kTrace:
      // unmet() leaves out a scene where the host renders; a trace has one all the same.
      refused = (against | published_unmet_.load(std::memory_order_acquire)) &
                (kFaultLatched | kEncoderStale | kNoScene | kBadConfig);
      if (now != Mode::kDisarmed && now != Mode::kReady) refused |= kWrongMode;
      break;
    case Command::kArm:
      if (now == Mode::kArmed) return 0;
      refused = against;
      break;
    case Command::kHome:
      refused = against & (kFaultLatched | kEncoderStale | kBadConfig);
      if (now != Mode::kDisarmed && now != Mode::kReady && now != Mode::kFaulted) refused |= kWrongMode;
      break;
    case Command::kClear:
      if (fault() == Fault::kNone) return 0;
      refused = against & (kEStopPressed | kDriveFault | kBadConfig);
      if (now != Mode::kFaulted) refused |= kWrongMode;
      break;
  }
  if (refused != 0) return static_cast<Conditions>(refused);
  post(command);
  return 0;
}

void Servo::post(Command command) noexcept {
  const std::uint32_t serial = (command_.load(std::memory_order_relaxed) >> kSerialShift) + 1U;
  command_.store(serial << kSerialShift | static_cast<std::uint32_t>(command), std::memory_order_release);
}

bool Servo::move_in_range(const MoveOrder& order) const noexcept {
  if (order.arm >= arm_count_ || !finite(order.target_m)) return false;
  const float max_N = std::min(params_.get(Param::max_force), arms_[order.arm].arm.model().max_force_N);
  return order.speed_m_s >= link::kMinMoveSpeed_m_s && order.speed_m_s <= link::kMaxMoveSpeed_m_s &&
         order.force_limit_N >= link::kMinMoveForce_N && order.force_limit_N <= link::kMaxMoveForce_N &&
         order.force_limit_N + GuardedMove::kForceMargin_N <= max_N;
}

Conditions Servo::request_move(const MoveOrder& order) noexcept {
  if (command_pending()) return kMoveUnderWay;
  unsigned refused = unmet_for_move();
  // The target, with room to spare; the tick stops the move where the straight way leaves the workspace.
  const kinematics::Arm<float>& arm = arms_[order.arm].arm;
  Vec3 joints;
  if (!arm.inverse(order.target_m, joints) ||
      kinematics::workspace_limit(arm.model(), joints, kWorkspaceMargin_rad) !=
          kinematics::WorkspaceLimit::kNone)
    refused |= kOutsideWorkspace;
  if (refused != 0) return static_cast<Conditions>(refused);
  posted_move_ = order;
  post(Command::kMove);
  return 0;
}

const GuardedMove* Servo::move_results() const noexcept {
  const link::MovePhase phase = move_phase();
  const bool still = phase == link::MovePhase::kNone || phase == link::MovePhase::kHolding;
  return still && !command_pending() ? &move_ : nullptr;
}

bool Servo::command_pending() const noexcept {
  return command_.load(std::memory_order_relaxed) >> kSerialShift !=
         command_done_.load(std::memory_order_acquire);
}

void Servo::keep_alive() noexcept {
  alive_.store(alive_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

bool Servo::post_scene(const control::SceneView& view, std::uint32_t sequence,
                       control::Binding binding) noexcept {
  if (scene_pending()) return false;
  posted_scene_ = view;
  posted_binding_ = binding;
  posted_sequence_ = sequence;
  scene_posted_.store(scene_posted_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  return true;
}

bool Servo::scene_pending() const noexcept {
  return scene_posted_.load(std::memory_order_relaxed) != scene_taken_.load(std::memory_order_acquire);
}

bool Servo::next_record(Telemetry& record) noexcept {
  const std::uint32_t tail = record_tail_.load(std::memory_order_relaxed);
  if (tail == record_head_.load(std::memory_order_acquire)) return false;
  record = records_[tail % kRecords];
  record_tail_.store(tail + 1, std::memory_order_release);
  return true;
}

bool Servo::next_scene_state(SceneState& state) noexcept {
  if (!scene_state_full_.load(std::memory_order_acquire)) return false;
  state = scene_state_;
  scene_state_full_.store(false, std::memory_order_release);
  return true;
}

std::size_t Servo::freeze_count() const noexcept {
  // A pending clear would let the tick write again while this reads.
  if (command_pending() || !frozen_.load(std::memory_order_acquire)) return 0;
  return std::min<std::size_t>(freeze_count_, kFreezeTicks);
}

bool Servo::freeze_tick(std::size_t index, Telemetry& tick) const noexcept {
  const std::size_t count = freeze_count();
  if (index >= count) return false;
  tick = freeze_[(freeze_count_ - count + index) % kFreezeTicks];
  return true;
}

}  // namespace thimble::firmware
