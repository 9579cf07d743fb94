// What the controller shows of a tick: the struct that the link encodes into frames, that the simulator logs, and that the
// freeze frame keeps. publish() of firmware/core/ fills it at the end of every tick.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "firmware/core/conditions.h"
#include "firmware/core/faults.h"
#include "firmware/core/modes.h"
#include "firmware/link/messages.h"
#include "kinematics/geometry.h"
#include "kinematics/vector.h"

namespace thimble::firmware {

using enum link::Limiter;  // which limiters changed the force or the currents of an arm in this tick; 0: none

struct ArmTelemetry {
  Vec3 tip_m = Vec3::Zero();  // world frame, like every vector here
  Vec3 tip_velocity_m_s = Vec3::Zero();
  Vec3 god_object_m = Vec3::Zero();
  Vec3 force_N = Vec3::Zero();  // what the arm is asked for, after all limits; on the hand
  Vec3 rendered_N =
      Vec3::Zero();  // what the force source asked for, before ramp and limits; 0 in a guarded move
  kinematics::PerAxis<float> joint_rad = kinematics::PerAxis<float>::Zero();
  kinematics::PerAxis<float> current_A = kinematics::PerAxis<float>::Zero();
  std::array<std::uint32_t, kinematics::kMaxJoints> counts{};  // as the board gave them
  std::array<float, kinematics::kMaxJoints>
      winding_C{};           // of the motors, by the thermal model; of the last record's tick
  std::uint64_t inside = 0;  // objects that the tip began inside of (control::Renderer::inside())
  std::uint8_t axes = 3;     // of the arm
  std::uint8_t contacts = 0;
  std::uint8_t limiters = 0;  // Limiter bits
};

struct Telemetry {
  std::uint64_t tick = 0;     // Inputs::tick
  std::uint64_t time_us = 0;  // Inputs::time_us
  float tick_us = 0;          // Inputs::last_tick_us: of the tick before
  Mode mode = Mode::kDisarmed;
  Fault fault = Fault::kNone;  // the first reason, until cleared
  float ramp = 0;        // 0 to 1: the part of the rendered force that arming and scene swaps let through
  Conditions unmet = 0;  // what refuses arming now
  std::uint8_t arm_count = 0;
  bool moves_itself = false;         // an arm follows a guarded move: on its way out, back, or holding
  std::uint32_t scene_sequence = 0;  // of the scene that is rendered; 0: none
  // Counters since power-on.
  std::uint32_t lost_ticks = 0;  // periods without a tick
  std::uint32_t overruns = 0;    // ticks that took longer than a period
  std::uint32_t stale_samples = 0;
  std::uint32_t trips = 0;
  std::uint32_t probes = 0;           // of the encoders (firmware/core/encoder_probe.h)
  std::uint32_t records_dropped = 0;  // telemetry that the background did not fetch in time
  float worst_tick_us = 0;
  // Since the scene was switched on.
  std::uint32_t contact_ticks = 0;
  float peak_force_N = 0;
  float mean_force_N = 0;  // over the contact ticks, of the arm that feels most
  control::RenderCounters bounds;
  std::array<ArmTelemetry, control::kMaxArms> arm;
};

}  // namespace thimble::firmware
