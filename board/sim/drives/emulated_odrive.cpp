#include "board/sim/drives/emulated_odrive.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace thimble::board::emulated {
namespace {

constexpr double kOdriveCounts = 8192;
constexpr double kOdriveVelocityLag_s = .002;
constexpr double kOdriveCurrentLag_s = .001;
constexpr std::uint32_t kEmergencyStop05 = 0x4000, kEmergencyStop06 = 0x02000000;
constexpr std::uint32_t kWatchdog05 = 0x800, kWatchdog06 = 0x01000000;

float float_at(const CanFrame& frame, std::size_t at) {
  float value = 0;
  std::memcpy(&value, &frame.data[at], 4);
  return value;
}

std::uint32_t word_at(const CanFrame& frame, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, &frame.data[at], 4);
  return value;
}

}  // namespace

EmulatedOdrive::EmulatedOdrive(std::uint8_t node, bool firmware06)
    : EmulatedDrive(kOdriveCurrentLag_s, kOdriveVelocityLag_s), node_(node), is06_(firmware06) {}

double EmulatedOdrive::encoder_step_rad() const { return kTurn_rad / kOdriveCounts; }

void EmulatedOdrive::reboot() {
  state_ = kIdle;
  error_ = 0;
  closed_loop_once_ = false;
  torque_N_m_ = 0;
  fed_us_ = now_us();
  zero_rad_ = shaft.position_rad;  // an incremental encoder
}

void EmulatedOdrive::disarm(std::uint32_t error) {
  error_ |= error;
  state_ = kIdle;  // phases off: it coasts
}

void EmulatedOdrive::set_watchdog_s(double time_s) {
  config.watchdog_s = time_s;
  endpoints[kTimeoutEndpoint] = std::bit_cast<std::uint32_t>(static_cast<float>(time_s));
}

void EmulatedOdrive::fail(std::uint32_t code) { disarm(code); }

void EmulatedOdrive::set_state(std::uint32_t state) {
  if (state == kClosedLoop && error_ == 0 && !stays_off) {
    state_ = kClosedLoop;
    closed_loop_once_ = true;
    ramped_N_m_ = 0;
  } else if (state == kIdle) {
    state_ = kIdle;
  }
}

double EmulatedOdrive::wanted_torque_N_m() {
  if (state_ != kClosedLoop) return 0;
  const double velocity = velocity_rad_s() / kTurn_rad;
  double torque = torque_N_m_;
  if (input_mode_ == 6) {
    const double most = config.torque_ramp_N_m_s * 25e-6;
    ramped_N_m_ += std::clamp(torque - ramped_N_m_, -most, most);
    torque = ramped_N_m_;
  }
  if (control_mode_ == 2) return torque + config.velocity_gain * (velocity_turns_s_ - velocity);
  if (control_mode_ != 1) return 0;
  if (config.torque_mode_velocity_limit) {
    const double limit = config.velocity_limit_turns_s, gain = config.velocity_gain;
    const double highest = (limit - velocity) * gain, lowest = (-limit - velocity) * gain;
    torque = std::clamp(torque, lowest, highest);
  }
  return torque;
}

void EmulatedOdrive::on_step() {
  const auto seconds = [](std::uint64_t us) { return static_cast<double>(us) * 1e-6; };
  const bool silent = seconds(now_us() - fed_us_) > config.watchdog_s;
  const std::uint32_t watchdog = is06_ ? kWatchdog06 : kWatchdog05;
  if (config.watchdog && !inject.watchdog_off && silent && (error_ & watchdog) == 0) disarm(watchdog);
  // On its own clock, which does not lose the parts of a step.
  const auto due = [&](double& next_us, double period_s) {
    const auto now = static_cast<double>(now_us());
    const double period_us = period_s * 1e6 * (1 + config.clock_drift);
    if (next_us == 0) next_us = now + period_us;
    if (period_s <= 0 || now < next_us) return false;
    next_us += period_us;
    return true;
  };
  if (due(heartbeat_us_, .1)) send_heartbeat();
  if (due(estimates_us_, config.estimates_s)) answer(0x09);
  if (due(iq_us_, config.iq_s)) answer(0x14);
  if (is06_ && due(torques_us_, config.torques_s)) answer(0x1C);
}

void EmulatedOdrive::send_heartbeat() {
  CanFrame out;
  out.id = static_cast<std::uint32_t>(node_) << 5U | 0x01U;
  out.size = 8;
  std::memcpy(out.data.data(), &error_, 4);
  out.data[4] = state_;
  if (is06_) out.data[5] = error_ != 0 ? 3 : 0;
  send(out);
}

void EmulatedOdrive::send_floats(std::uint8_t command, double first, double second) {
  CanFrame out;
  out.id = static_cast<std::uint32_t>(node_) << 5U | command;
  out.size = 8;
  const auto a = static_cast<float>(first), b = static_cast<float>(second);
  std::memcpy(&out.data[0], &a, 4);
  std::memcpy(&out.data[4], &b, 4);
  send(out);
}

void EmulatedOdrive::answer(std::uint8_t command) {
  const double current = reported_torque_N_m() / config.torque_constant_N_m_A;
  switch (command) {
    case 0x00: {
      if (!is06_) return;
      CanFrame out;
      out.id = static_cast<std::uint32_t>(node_) << 5U;
      out.size = 8;
      out.data = {2, 4, 4, 58, 0, config.minor, 9, 0};
      send(out);
      return;
    }
    case 0x01:
      return send_heartbeat();
    case 0x09:  // exactly 0 until the first closed loop
      if (!closed_loop_once_) return send_floats(command, 0, 0);
      return send_floats(command, (read_encoder_rad() - zero_rad_) / kTurn_rad, velocity_rad_s() / kTurn_rad);
    case 0x14:
      return send_floats(command, torque_N_m_ / config.torque_constant_N_m_A, current);
    case 0x17:
      return send_floats(command, 24, 1);
    case 0x1C:
      if (is06_) send_floats(command, torque_N_m_, reported_torque_N_m());
      return;
    default:
      return;
  }
}

void EmulatedOdrive::on_frame(const CanFrame& frame) {
  if (frame.extended || frame.fd || frame.id >> 5U != node_) return;
  fed_us_ = now_us();  // by any frame to the node
  const auto command = static_cast<std::uint8_t>(frame.id & 0x1FU);
  if (frame.remote || (frame.size == 0 && command != 0x02 && command != 0x16 && command != 0x18))
    return answer(command);
  switch (command) {
    case 0x02:
      return disarm(is06_ ? kEmergencyStop06 : kEmergencyStop05);
    case 0x04: {
      if (!is06_ || frame.data[0] != 0) return;
      const auto endpoint = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
      const auto found = endpoints.find(endpoint);
      if (found == endpoints.end()) return;
      CanFrame out = frame;
      out.id = static_cast<std::uint32_t>(node_) << 5U | 0x05U;
      std::memcpy(&out.data[4], &found->second, 4);
      return send(out);
    }
    case 0x07:
      return set_state(word_at(frame, 0));
    case 0x0B:
      control_mode_ = word_at(frame, 0);
      input_mode_ = word_at(frame, 4);
      return;
    case 0x0D:
      velocity_turns_s_ = static_cast<double>(float_at(frame, 0));
      torque_N_m_ = static_cast<double>(float_at(frame, 4));
      return;
    case 0x0E:  // four bytes are read
      torque_N_m_ = static_cast<double>(float_at(frame, 0));
      return;
    case 0x0F:
      config.velocity_limit_turns_s = static_cast<double>(float_at(frame, 0));
      return;
    case 0x16:
      return reboot();
    case 0x18:
      error_ = 0;
      return;
    case 0x1B:
      config.velocity_gain = static_cast<double>(float_at(frame, 0));
      integrator_gain_ = static_cast<double>(float_at(frame, 4));
      return;
    default:
      return;
  }
}

}  // namespace thimble::board::emulated
