// The simulated arm behind emulated drives: their torques move it, and it moves their shafts. The hand holds the tip at the start of its path
// until the first torque, or until the drives have followed commands for half a second (an arm without weight has no torque until it is touched).
// It follows the path from then on, and goes back to its start when the drives have gone off.
//
// Each time when the drives stop to follow commands, by a command, a fault or their watchdogs, it says what the hand felt until then and what the
// tip did. Uses the heap.
// Units: SI; times in microseconds of the drives' clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "board/sim/drives/emulated_drive.h"
#include "board/sim/hand_path.h"
#include "board/sim/sim_arm.h"

namespace thimble::board::emulated {

class DrivenArm {
 public:
  // arm: at rest with the tip at home. drives: of its motors in the order of the axes, one for each; they must outlive it.
  DrivenArm(const SimArm& arm, const HandPath& path, std::vector<EmulatedDrive*> drives);
  [[nodiscard]] static std::size_t motors_of(const kinematics::ArmData& arm);

  // After the drives were moved on to now_us. frames: that they have heard so far, of all.
  void advance(std::uint64_t now_us, std::uint64_t frames);
  // What the tip did since the last command before the drives went off, as a line of JSON, once 0.1 s are over. With hand_N and tip_mm, the force
  // on the hand and the place of the tip in the world when that command came, both smoothed with a time constant of 0.5 s.
  [[nodiscard]] std::optional<std::string> take_report();

 private:
  void step(double seconds);
  void watch(std::uint64_t now_us, std::uint64_t frames);

  SimArm arm_;
  HandPath path_;
  std::vector<EmulatedDrive*> drives_;
  std::vector<std::size_t> axes_;  // of the drives
  SimArm::PerAxis last_rotors_rad_;
  std::uint64_t now_us_ = 0;                    // 0: not started
  std::optional<double> since_s_, on_since_s_;  // of the arm's time: the path has begun; all drives follow
  Vector3d tip_now_m_;

  bool followed_ = false;
  std::uint64_t frames_ = 0;
  std::uint64_t command_us_ = 0;       // of the last command that was followed
  Vector3d tip_m_ = Vector3d::Zero();  // then
  Vector3d felt_N_ = Vector3d::Zero(), felt_at_m_ = Vector3d::Zero();          // smoothed
  Vector3d reported_N_ = Vector3d::Zero(), reported_at_m_ = Vector3d::Zero();  // at the last command
  std::uint64_t off_us_ = 0;                                                   // 0: not measured
  double held_m_ = 0, travel_m_ = 0, speed_m_s_ = 0;
  std::optional<std::string> report_;
};

}  // namespace thimble::board::emulated
