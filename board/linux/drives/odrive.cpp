#include "board/linux/drives/odrive.h"

#include "board/linux/drives/bytes.h"

namespace thimble::board::drives::odrive {
namespace {

constexpr std::uint8_t kPassthrough = 1;
constexpr std::uint8_t kSdoRead = 0;
// Errors of 0.6 that limit and do not disarm.
constexpr std::uint32_t kCurrentLimit06 = 0x1000;

CanFrame frame_of(std::uint8_t node, Message message, std::uint8_t size) {
  CanFrame frame;
  frame.id = id_of(node, message);
  frame.size = size;
  return frame;
}

CanFrame two_floats(std::uint8_t node, Message message, float first, float second) {
  CanFrame frame = frame_of(node, message, 8);
  put_float(frame, 0, first);
  put_float(frame, 4, second);
  return frame;
}

Stage stage_of(std::uint8_t axis_state) {
  if (axis_state == static_cast<std::uint8_t>(AxisState::kIdle)) return Stage::kOff;
  if (axis_state == static_cast<std::uint8_t>(AxisState::kClosedLoop)) return Stage::kOn;
  return axis_state == 0 ? Stage::kUnknown : Stage::kStarting;
}

void take_heartbeat(bool firmware06, const CanFrame& frame, Sample& sample) {
  std::uint32_t error = get_u(frame, 0, 4);
  const bool parts = !firmware06 && ((frame.data[5] | frame.data[6] | frame.data[7]) & 1U) != 0;
  if (error == 0 && parts) error = kPartError05;
  sample.stage = stage_of(frame.data[4]);
  const bool limits = firmware06 && error == kCurrentLimit06 && sample.stage == Stage::kOn;
  sample.limiter = limits ? Limiter::kCurrent : Limiter::kNone;
  sample.drive_fault = limits ? 0 : error;
  const std::uint32_t watchdog = firmware06 ? kWatchdogError06 : kWatchdogError05;
  if (sample.drive_fault != 0)
    sample.stage = (sample.drive_fault & watchdog) != 0 ? Stage::kTimedOut : Stage::kFaulted;
  // 0.5 reports a position of exactly 0 until the first closed loop.
  if (sample.stage == Stage::kOn) sample.position_valid = true;
}

// What only a host sends: another program of this machine may have, such as the board's guardian.
bool is_command(Message message) {
  switch (message) {
    case Message::kEmergencyStop:
    case Message::kRxSdo:
    case Message::kAxisState:
    case Message::kControllerModes:
    case Message::kInputVelocity:
    case Message::kInputTorque:
    case Message::kLimits:
    case Message::kReboot:
    case Message::kClearErrors:
    case Message::kVelocityGains:
      return true;
    case Message::kVersion:
    case Message::kHeartbeat:
    case Message::kError:
    case Message::kTxSdo:
    case Message::kEstimates:
    case Message::kIq:
    case Message::kTemperature:
    case Message::kSupply:
    case Message::kTorques:
      return false;
  }
  return false;
}

}  // namespace

CanFrame pack_request(std::uint8_t node, Message message) noexcept {
  CanFrame frame = frame_of(node, message, 0);
  frame.remote = true;
  return frame;
}

CanFrame pack_axis_state(std::uint8_t node, AxisState state) noexcept {
  CanFrame frame = frame_of(node, Message::kAxisState, 8);
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

CanFrame pack_controller_modes(std::uint8_t node, ControlMode mode) noexcept {
  CanFrame frame = frame_of(node, Message::kControllerModes, 8);
  frame.data[0] = static_cast<std::uint8_t>(mode);
  frame.data[4] = kPassthrough;
  return frame;
}

CanFrame pack_torque(std::uint8_t node, float torque_N_m) noexcept {
  CanFrame frame = frame_of(node, Message::kInputTorque, 4);
  put_float(frame, 0, torque_N_m);
  return frame;
}

CanFrame pack_damped_torque(std::uint8_t node, float torque_N_m) noexcept {
  return two_floats(node, Message::kInputVelocity, 0, torque_N_m);
}

CanFrame pack_damping(std::uint8_t node, float damping_N_m_s_rad) noexcept {
  return two_floats(node, Message::kVelocityGains, damping_N_m_s_rad * kTurn_rad, 0);
}

CanFrame pack_limits(std::uint8_t node, float velocity_rad_s, float current_A) noexcept {
  return two_floats(node, Message::kLimits, velocity_rad_s / kTurn_rad, current_A);
}

CanFrame pack_clear_errors(std::uint8_t node, bool firmware06) noexcept {
  return frame_of(node, Message::kClearErrors, firmware06 ? 1 : 0);
}

CanFrame pack_emergency_stop(std::uint8_t node) noexcept {
  return frame_of(node, Message::kEmergencyStop, 0);
}

CanFrame pack_read_endpoint(std::uint8_t node, std::uint16_t endpoint) noexcept {
  CanFrame frame = frame_of(node, Message::kRxSdo, 8);
  frame.data[0] = kSdoRead;
  put_u(frame, 1, endpoint, 2);
  return frame;
}

Unpacked unpack(std::uint8_t node, bool firmware06, float torque_constant_N_m_A, const CanFrame& frame,
                Sample& sample) noexcept {
  Unpacked out;
  if (frame.extended || frame.remote || frame.id >> 5U != node || frame.size == 0) return out;
  out.message = static_cast<Message>(frame.id & 0x1FU);
  if (is_command(out.message)) return out;
  if (frame.size != 8) {
    out.reply = Reply::kMalformed;
    return out;
  }
  out.reply = Reply::kTelemetry;
  switch (out.message) {
    case Message::kVersion:
      out.reply = Reply::kAnswer;
      out.version = {frame.data[0], frame.data[4], frame.data[5], frame.data[6]};
      break;
    case Message::kHeartbeat:
      take_heartbeat(firmware06, frame, sample);
      break;
    case Message::kEstimates:
      out.reply = Reply::kMotion;
      sample.position_rad = get_float(frame, 0) * kTurn_rad;
      sample.velocity_rad_s = get_float(frame, 4) * kTurn_rad;
      break;
    case Message::kIq:
      sample.current_A = get_float(frame, 4);
      if (!firmware06) sample.torque_N_m = torque_constant_N_m_A * sample.current_A;
      break;
    case Message::kTemperature:
      if (!firmware06) break;  // the estimate of a sensorless motor
      sample.drive_C = get_float(frame, 0);
      sample.motor_C = get_float(frame, 4);
      break;
    case Message::kSupply:
      sample.supply_V = get_float(frame, 0);
      break;
    case Message::kTorques:
      if (firmware06) sample.torque_N_m = get_float(frame, 4);
      break;
    case Message::kTxSdo:
      if (!firmware06) break;  // an error of the sensorless estimator
      out.reply = Reply::kAnswer;
      out.endpoint = static_cast<std::uint16_t>(get_u(frame, 1, 2));
      out.value = get_u(frame, 4, 4);
      break;
    case Message::kEmergencyStop:
    case Message::kError:
    case Message::kRxSdo:
    case Message::kAxisState:
    case Message::kControllerModes:
    case Message::kInputVelocity:
    case Message::kInputTorque:
    case Message::kLimits:
    case Message::kReboot:
    case Message::kClearErrors:
    case Message::kVelocityGains:
      break;
  }
  return out;
}

}  // namespace thimble::board::drives::odrive
