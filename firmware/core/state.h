// The state that the tick keeps from one tick to the next, except that of the force sources. Telemetry shows it, and the start record of
// a recording describes it. The steps of firmware/core/steps.h are functions over it. Units: SI, world frame.
#pragma once

#include <array>
#include <cstdint>

#include "control/renderer_types.h"
#include "firmware/core/config.h"
#include "firmware/core/encoder_probe.h"
#include "firmware/core/encoder_watch.h"
#include "firmware/core/faults.h"
#include "firmware/core/force_limits.h"
#include "firmware/core/modes.h"
#include "firmware/core/persists.h"
#include "firmware/core/setup.h"
#include "firmware/core/speed_watch.h"
#include "firmware/core/thermal.h"
#include "firmware/observe/telemetry.h"
#include "kinematics/arm.h"
#include "kinematics/encoder.h"
#include "kinematics/vector.h"
#include "kinematics/velocity.h"

namespace thimble::firmware {

struct ArmState {
  ArmState(const kinematics::Arm<float>& arm, float period_s) noexcept;

  // Sensed.
  std::array<kinematics::JointEncoder, kJoints> encoder;
  std::array<kinematics::VelocityEstimator, kJoints> speed;
  std::array<EncoderWatch, kJoints> watch;
  std::array<bool, kJoints> suspect{};  // of being frozen, by `watch`
  std::array<MotorHeat, kJoints> heat;
  EncoderProbe probe;
  SpeedWatch speed_watch;
  Persists current_off, supply_off;
  bool seen = false;  // a first sample has arrived
  bool homed = false;
  bool in_workspace = false;
  std::uint64_t sample_tick = 0;
  std::uint64_t age_ticks = 0;  // of the newest sample
  std::size_t axes = 0;
  bool redundant = false;  // more axes have a motor than a force has directions
  Axes joint_rad = Axes::Zero();
  kinematics::Posture<float> posture;
  Vec3 tip_velocity_m_s = Vec3::Zero();
  // Driven. Until drive() is called in a tick, these are the values of the tick before.
  ForceSource* source = nullptr;  // the guest that leads this arm; null: State::source gives its force
  const Axes* led_N_m = nullptr;  // torques of the axes that a guest asks for; null: they follow from force_N
  Vec3 force_N = Vec3::Zero();    // after all limits
  Vec3 unprobed_N = Vec3::Zero();  // before a probe of the encoders took some of it away
  float given = 1;  // the part of the torques that the motors' limits let through; during a probe, as before
  ForceAccount limits;   // what the limits have kept back
  float braked_m_s = 0;  // while the tip is braked: the speed that it should have at most
  Axes torque_N_m = Axes::Zero();
  Axes current_A = Axes::Zero();
  std::uint8_t limiters = 0;  // Limiter bits of this tick
};

struct State {
  State(const Setup& setup, ForceSource& first_source) noexcept
      : arm{ArmState(setup.arm[0], setup.period_s), ArmState(setup.arm[1], setup.period_s)},
        source(&first_source) {}

  std::uint64_t tick = 0;  // Inputs::tick
  std::uint64_t lost = 0;  // periods between the last tick and this one
  bool first_tick = true;
  float overload_s = 0;    // time of ticks that took longer than a period, less what came in time since
  float heat_shown_s = 0;  // since the background was last told the motors' heat

  Mode mode = Mode::kDisarmed;
  float mode_time_s = 0;  // since the mode changed
  StoppedBy stopped_by = StoppedBy::kNothing;
  Fault fault = Fault::kNone;
  std::uint32_t faults_seen = 0;  // bit n: fault n occurred since the last clear
  std::uint32_t fault_tick = 0;   // low 32 bits of the tick in which the first one latched

  std::uint32_t link_age_ticks = 0;  // since the host's last sign of life
  bool link_seen = false;            // the last sign of life is younger than link_timeout
  std::uint32_t alive_seen = 0;      // Commands::alive() in the tick before
  std::uint32_t stops_seen = 0;      // Commands::stops() in the tick before
  bool stop_ordered = false;         // a stop has been requested since the tick before
  std::uint32_t disarms_seen = 0;    // Commands::disarms() in the tick before
  bool disarm_ordered = false;       // a disarm has been requested since the tick before

  std::uint32_t pulse_ticks = 0;  // for which the event line stays active

  std::array<ArmState, kMaxArms> arm;

  ForceSource* source;  // of all arms; chosen at arming, and kept until the next arming
  bool guest = false;   // an arm is led by a guest
  std::array<control::Touch, kMaxArms> touch{};  // of the sources in this tick, before ramp and limits
  bool in_contact = false;                       // any arm touches something, as `source` reports
  float force_ramp = 0;                          // 0 to 1: factor on the forces of `source`
  float gravity_ramp = 0;                        // 0 to 1: factor on the compensation of the arm's weight

  Telemetry telemetry;  // of the last tick; its counters continue from tick to tick
};

[[nodiscard]] inline bool all_homed(const Setup& setup, const State& state) noexcept {
  for (std::size_t i = 0; i < setup.arm_count; ++i)
    if (!state.arm[i].homed) return false;
  return setup.arm_count != 0;
}

}  // namespace thimble::firmware
