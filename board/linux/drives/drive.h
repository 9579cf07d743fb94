// What all supported motor drives have in common: one command, one sample, and the names of states, limiters and kinds.
//
// Units: SI, at the shaft that the drive itself reports (moteus: its output after rotor_to_output_ratio; ODrive: the motor; MIT mode and
// Damiao: the output). A gear outside the drive belongs to the arm's model, not here. Each codec converts once, at its edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "firmware/link/can_frame.h"

namespace thimble::board::drives {

using firmware::link::CanFrame;

inline constexpr float kTurn_rad = 2.0F * std::numbers::pi_v<float>;
inline constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

enum class Kind : std::uint8_t {
  kMoteus,
  kOdrive05,     // CANSimple of firmware 0.5
  kOdrive06,     // of firmware 0.6
  kMiniCheetah,  // MIT mode, as motorcontrol has it
  kCubeMars,     // MIT mode with temperature and error in the reply
  kDamiao,       // MIT mode with registers, classic frames
  kDamiaoFd,     // the same, FD frames with bit rate switch
};
[[nodiscard]] constexpr bool is_moteus(Kind kind) { return kind == Kind::kMoteus; }
[[nodiscard]] constexpr bool is_odrive(Kind kind) {
  return kind == Kind::kOdrive05 || kind == Kind::kOdrive06;
}
[[nodiscard]] constexpr bool is_damiao(Kind kind) { return kind == Kind::kDamiao || kind == Kind::kDamiaoFd; }
[[nodiscard]] constexpr bool is_mit(Kind kind) { return !is_moteus(kind) && !is_odrive(kind); }
[[nodiscard]] constexpr bool is_fd(Kind kind) { return kind == Kind::kMoteus || kind == Kind::kDamiaoFd; }

// The torque at the shaft is torque_N_m - damping_N_m_s_rad * velocity.
struct Command {
  float torque_N_m = 0;
  float damping_N_m_s_rad = 0;
};

// What the drive says of its power stage.
enum class Stage : std::uint8_t {
  kUnknown,
  kOff,       // no current; its faults, if any, are cleared
  kStarting,  // calibrating, changing modes
  kOn,        // follows torque commands
  kTimedOut,  // its watchdog ended the commands
  kFaulted,   // drive_fault says why
};

// What keeps a drive from the torque that was asked for. It is shown and does not stop the drive.
enum class Limiter : std::uint8_t {
  kNone,
  kTorque,       // the maximum torque commanded or configured
  kCurrent,      // the maximum current
  kVoltage,      // the supply
  kTemperature,  // derating
  kOther,        // another limit of the drive
  kUnseen,  // none is reported, but the torque reported differs from the one asked for (torque_witness.h)
};

// What a drive has said so far. A field that it has not sent is NaN.
struct Sample {
  float position_rad = kNoValue;  // as the drive counts: it may wrap (unwrap.h)
  float velocity_rad_s = kNoValue;
  float torque_N_m = kNoValue;
  float current_A = kNoValue;  // the q axis
  float supply_V = kNoValue;
  float drive_C = kNoValue;
  float motor_C = kNoValue;
  Stage stage = Stage::kUnknown;
  Limiter limiter = Limiter::kNone;
  bool position_valid =
      true;  // false: a number that is no position yet (ODrive before its first closed loop)
  std::uint8_t home_state = 0;    // moteus: 0 relative, 1 rotor known, 2 output known
  std::uint16_t counter_ms = 0;   // moteus: its clock, proof of a fresh reply
  std::uint32_t drive_fault = 0;  // the drive's own code; 0: none
};

// What a frame from a drive was.
enum class Reply : std::uint8_t {
  kOther,      // not of this drive, or no frame of the protocol
  kMalformed,  // of this drive, but not as the protocol says
  kMotion,     // position and velocity (and more): the answer to a tick's command
  kTelemetry,  // anything else of the sample
  kRejected,   // the drive refuses a register or a value
  kAnswer,     // a value of its configuration was asked for
};

}  // namespace thimble::board::drives
