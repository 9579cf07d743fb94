// What the emulated drives have in common: a shaft with its motor, the encoder, replies that come late, and faults to inject.
//
// An emulated drive is fed with frames and time, and gives frames. It shares no code with the codecs of board/linux/drives: it decodes
// commands and encodes replies by the same tables. Uses the heap. Units: SI at the drive's shaft, times in microseconds of any clock that
// does not go back. It emulates bytes and state machines, not electricity: see docs/drives.md for what it does not show.
#pragma once

#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/link/can_frame.h"

namespace thimble::board::emulated {

using firmware::link::CanFrame;

inline constexpr double kTurn_rad = 2 * std::numbers::pi;

// A joint as a drive feels it.
struct Shaft {
  double position_rad = 0;
  double velocity_rad_s = 0;
  double inertia_kg_m2 = 1e-3;
  double friction_N_m_s_rad = 1e-3;
  double hand_N_m = 0;  // from outside
  bool moves = true;    // false: something else moves it (driven_arm.h)
};

// Faults. A count is of the next frames; the rest lasts until it is taken back.
struct Injection {
  unsigned drop_replies = 0;
  unsigned repeat_replies = 0;
  bool mute = false;                // neither hears nor answers, and keeps doing what it did
  std::uint64_t more_delay_us = 0;  // of replies
  bool answer_classic = false;      // to FD frames
  std::uint32_t reply_id = 0;       // instead of its own; 0: its own
  bool watchdog_off = false;
  bool encoder_frozen = false;
  double encoder_jump_rad = 0;   // added to what the encoder reads
  double encoder_noise_rad = 0;  // half of the width
  double torque_factor = 1;      // of the motor, not of what is reported: -1: two phases swapped
  double current_factor = 1;     // of the current, which is reported
  double most_torque_N_m = 1e9;  // derating that no limiter names
  bool clock_stands = false;     // moteus: its counter
};

struct Outgoing {
  std::uint64_t due_us = 0;
  CanFrame frame;
};

class EmulatedDrive {
 public:
  virtual ~EmulatedDrive() = default;

  // A frame on the bus at now_us; advance() to now_us has been called.
  void hear(const CanFrame& frame, std::uint64_t now_us);
  void advance(std::uint64_t now_us);
  // Frames that are due; the caller takes them from the list.
  [[nodiscard]] std::vector<Outgoing>& outgoing() { return outgoing_; }

  // As after a power cut: the position is what the encoder knows at power-on.
  virtual void reboot() = 0;
  void power_cycle(std::uint64_t boot_us);  // reboot(), and neither hears nor answers before it has booted
  virtual void set_watchdog_s(double time_s) = 0;  // of its configuration
  virtual void fail(std::uint32_t code) = 0;       // a fault of its own
  [[nodiscard]] virtual bool powered() const = 0;
  [[nodiscard]] virtual bool follows() const = 0;  // gives the torque of its last command

  [[nodiscard]] double torque_N_m() const { return torque_N_m_; }  // at the shaft

  Shaft shaft;
  Injection inject;

 protected:
  explicit EmulatedDrive(double current_lag_s, double velocity_lag_s);

  virtual void on_frame(const CanFrame& frame) = 0;
  virtual double wanted_torque_N_m() = 0;  // 0 when off
  virtual void on_step() = 0;              // timers; every 25 us
  [[nodiscard]] virtual double encoder_step_rad() const = 0;

  void send(const CanFrame& frame);
  [[nodiscard]] std::uint64_t now_us() const { return now_us_; }
  [[nodiscard]] double read_encoder_rad();
  [[nodiscard]] double velocity_rad_s() const { return velocity_rad_s_; }    // as the drive estimates it
  [[nodiscard]] double reported_torque_N_m() const { return current_N_m_; }  // from the current

 private:
  static constexpr std::uint64_t kStep_us = 25;
  static constexpr std::uint64_t kTurnaround_us = 60;

  void step();

  double current_lag_s_;
  double velocity_lag_s_;
  std::uint64_t now_us_ = 0;
  bool started_ = false;
  std::uint64_t booted_us_ = 0;
  double current_N_m_ = 0;
  double torque_N_m_ = 0;
  double velocity_rad_s_ = 0;
  double frozen_rad_ = 0;
  std::mt19937 random_{1};
  std::vector<Outgoing> outgoing_;
};

}  // namespace thimble::board::emulated
