// A drive in MIT mode: mini-cheetah (motorcontrol), CubeMars or Damiao. It answers a command with the sample from before the command.
//
// Sources: bgkatz/motorcontrol 3586419, enactic/openarm_can 9866604, cmjang/DM_Control_Python 7da9387. Units on the wire: codes of ranges.
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "board/sim/drives/emulated_drive.h"

namespace thimble::board::emulated {

class EmulatedMit final : public EmulatedDrive {
 public:
  enum class Flavour : std::uint8_t { kMiniCheetah, kCubeMars, kDamiao };

  EmulatedMit(Flavour flavour, std::uint16_t id, std::uint16_t reply_id, double velocity_rad_s,
              double torque_N_m);

  void reboot() override;
  void set_watchdog_s(double time_s) override;
  void fail(std::uint32_t code) override;  // CubeMars: 1 to 6; Damiao: a nibble
  [[nodiscard]] bool powered() const override { return enabled_; }
  [[nodiscard]] bool follows() const override { return enabled_ && !timed_out_; }
  [[nodiscard]] std::uint32_t error() const { return error_; }
  [[nodiscard]] unsigned zeroed() const {
    return zeroed_;
  }  // how often it was told to take its place for zero

  bool takes_fd = false;                            // Damiao: can_br is 5 Mbit/s
  bool old_reply = false;                           // mini-cheetah: six bytes
  std::map<std::uint8_t, std::uint32_t> registers;  // Damiao; 9, the timeout, is the others' too

 private:
  struct Orders {
    double position_rad = 0, velocity_rad_s = 0, kp = 0, kd = 0, torque_N_m = 0;
  };

  void on_frame(const CanFrame& frame) override;
  double wanted_torque_N_m() override;
  void on_step() override;
  double encoder_step_rad() const override;

  void answer(bool fd);
  void answer_register(const CanFrame& frame);
  void take_magic(std::uint8_t last);
  [[nodiscard]] double timeout_s() const;

  Flavour flavour_;
  std::uint16_t id_, reply_id_;
  double velocity_top_, torque_top_;
  bool enabled_ = false;
  bool timed_out_ = false;  // goes on with the next frame
  std::uint32_t error_ = 0;
  Orders orders_;
  double smoothed_N_m_ = 0;
  double zero_rad_ = 0;
  unsigned zeroed_ = 0;
  std::uint64_t heard_us_ = 0;
};

}  // namespace thimble::board::emulated
