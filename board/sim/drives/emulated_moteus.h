// A moteus controller: registers, mode 10 with its watchdog, the modes of a timeout, and `conf get` over the diagnostic stream.
//
// Source: mjbots/moteus db1a762, fw/moteus_controller.cc, fw/bldc_servo.cc, docs/protocol. Units on the wire: turns, N m.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <string>

#include "board/sim/drives/emulated_drive.h"

namespace thimble::board::emulated {

class EmulatedMoteus final : public EmulatedDrive {
 public:
  explicit EmulatedMoteus(std::uint8_t id);

  void reboot() override;
  void set_watchdog_s(double time_s) override;
  void fail(std::uint32_t code) override;
  [[nodiscard]] bool powered() const override;
  [[nodiscard]] bool follows() const override { return mode_ == 9 || mode_ == 10; }
  [[nodiscard]] int mode() const { return mode_; }
  [[nodiscard]] double kd_scale() const { return active_.kd_scale; }

  // What `conf get` answers: servo.default_timeout_s, servo.timeout_mode (12 zero velocity, 15 brake), servo.pid_position.kp and .kd
  // (N m per turn and turn/s), servo.timeout_max_torque_Nm, ...
  std::map<std::string, double> config;
  std::uint8_t home_state = 1;
  std::uint32_t refuses_register = 0xFFFF;  // as an older firmware that lacks it
  std::uint32_t limiter = 0;                // 96 to 103 in the fault register

 private:
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  struct Orders {
    int mode = 0;
    double position = 0;  // turns; NaN: none
    double velocity = 0;
    double torque_N_m = 0;
    double kp_scale = 1, kd_scale = 1;
    double most_torque_N_m = 100;
    double timeout_s = 0;  // 0 or NaN: the configured one
  };
  struct Reply;

  void on_frame(const CanFrame& frame) override;
  double wanted_torque_N_m() override;
  void on_step() override;
  double encoder_step_rad() const override;

  void take_subframes(const CanFrame& frame, Reply& reply);
  [[nodiscard]] bool write(std::uint32_t reg, double value);
  [[nodiscard]] bool read(std::uint32_t reg, double& value);
  void apply(const Orders& orders);
  void answer_text(const std::string& text);
  [[nodiscard]] double damped(double kd) const;

  std::uint8_t id_;
  int mode_ = 0;
  std::uint32_t fault_ = 0;
  Orders pending_, active_;
  std::uint64_t ordered_us_ = 0;
  std::uint64_t booted_us_ = 0;
  std::uint64_t stood_us_ = 0;
  double zero_rad_ = 0;  // of the position reported
  bool commanded_ = false;
  std::string heard_text_, text_;
};

}  // namespace thimble::board::emulated
