// An axis of an ODrive, firmware 0.5 or 0.6: CANSimple, cyclic messages on its own clock, the watchdog that any frame feeds.
//
// Source: odriverobotics/ODrive f9b5419 (0.5.6); of 0.6 the message layout alone. Units on the wire: turns, N m of the motor's shaft.
#pragma once

#include <bit>
#include <cstdint>
#include <map>

#include "board/sim/drives/emulated_drive.h"

namespace thimble::board::emulated {

class EmulatedOdrive final : public EmulatedDrive {
 public:
  EmulatedOdrive(std::uint8_t node, bool firmware06);

  void reboot() override;
  void set_watchdog_s(double time_s) override;
  void fail(std::uint32_t code) override;
  [[nodiscard]] bool powered() const override { return state_ == kClosedLoop; }
  [[nodiscard]] bool follows() const override { return powered(); }
  [[nodiscard]] std::uint32_t error() const { return error_; }

  // As a person has configured it.
  struct Config {
    double watchdog_s = .015;
    bool watchdog = true;  // off by default in a real one
    double torque_constant_N_m_A = .04;
    double estimates_s = .001;  // whole milliseconds; 0: on request alone
    double iq_s = .01;
    double torques_s = .01;  // 0.6
    double clock_drift = 1e-4;
    double velocity_limit_turns_s = 2;
    bool torque_mode_velocity_limit = true;  // takes torque away near the limit
    double velocity_gain = .167;             // N m/(turn/s)
    double torque_ramp_N_m_s = .01;          // of input mode 6
    std::uint8_t input_mode = 6;             // until another is sent
    std::uint8_t minor = 6;                  // of the version of 0.6
  };
  Config config;
  bool stays_off = false;  // refuses closed loop, as before calibration
  // 0.6: what TxSdo tells, by their numbers in a release that does not exist: enable_watchdog and watchdog_timeout.
  std::map<std::uint16_t, std::uint32_t> endpoints{{100, 1},
                                                   {kTimeoutEndpoint, std::bit_cast<std::uint32_t>(.015F)}};

 private:
  static constexpr std::uint8_t kIdle = 1, kClosedLoop = 8;
  static constexpr std::uint16_t kTimeoutEndpoint = 101;

  void on_frame(const CanFrame& frame) override;
  double wanted_torque_N_m() override;
  void on_step() override;
  double encoder_step_rad() const override;

  void answer(std::uint8_t command);
  void send_floats(std::uint8_t command, double first, double second);
  void send_heartbeat();
  void set_state(std::uint32_t state);
  void disarm(std::uint32_t error);

  std::uint8_t node_;
  bool is06_;
  std::uint8_t state_ = kIdle;
  bool closed_loop_once_ = false;
  std::uint32_t error_ = 0;
  std::uint32_t control_mode_ = 3;
  std::uint32_t input_mode_ = 6;
  double torque_N_m_ = 0, velocity_turns_s_ = 0, ramped_N_m_ = 0;
  double integrator_gain_ = 0;
  double zero_rad_ = 0;
  std::uint64_t fed_us_ = 0;
  double heartbeat_us_ = 0, estimates_us_ = 0, iq_us_ = 0, torques_us_ = 0;  // when each is due
};

}  // namespace thimble::board::emulated
