// One fault of the hardware while a hand is at the arm, judged by what the hand feels of it.
//
// Three runs with the same hand: the faulty one, a sound one, and one whose amplifiers are off from the instant of the fault. Whatever
// lies between what the sound arm and the arm without power do, the hand does itself. What is outside is the arm's:
//
//   travel   the greatest distance of the tip from the line between the two other tips at the same time
//   impulse  the time integral of what the force on the hand is beyond the line between the two other forces: its greatest size
//   speed    the greatest speed of the tip, less the greatest of the two others
//
// from the instant of the fault until the drives are off and the tip is slower than 0.05 m/s. Units: SI.
//
// A host gives signs of life over a link that may be broken, and reads all that the board sends. Injection::kProcessKilled: the process is
// gone for a while, and starts again.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/sim_board.h"

namespace thimble::test {

enum class Doing { kFree, kContact, kHoming, kMove };

struct Trial {
  Doing doing = Doing::kContact;
  std::vector<board::PlannedFault> faults;  // at_s: after the instant of the fault
  std::vector<board::PlannedFault> hand;    // what the hand does then, in all runs
  std::string variant = "premium-1.5";
  double rate_Hz = 4000;
  std::uint8_t arms = 1;  // the first is judged, with the second in the same scene and contact
  board::Sensors sensors{};
  board::Hand holds{};
  double force_N = 0;  // with which the hand presses; 0: 80 % of the arm's peak force or of max_force
  Eigen::Vector3d normal{0, 0, 1};  // of the wall
  float stiffness_N_m = 1000, friction = 0;
  double tremor_m = 0;   // amplitude of the hand's, at 9 Hz and 11 Hz
  double lifts_m_s = 0;  // from the fault on the hand goes out of the wall this fast, or further in
  double phase_s = 0;    // the instant of the fault comes this much later
  double watch_s = 1.5;  // longest
  std::vector<std::pair<firmware::Param, std::uint32_t>> params;  // written before the arm is homed, as bits
  bool supervised = false;  // a host that is silent for 0.1 s is a fault
};

struct Verdict {
  firmware::Fault fault = firmware::Fault::kNone;  // that the controller names
  std::optional<double> found_s, off_s;            // after the instant of the fault
  double travel_m = 0, speed_m_s = 0, impulse_N_s = 0;
  bool armed_again = false;              // the drives, after they were off and the tip slow; not to brake
  std::array<double, 3> last_count_s{};  // of each joint, before a fault was named
  std::uint32_t probes = 0;              // of the encoders
  // The greatest part of the force of the sound arm, which is not probed, that is gone; and the greatest change of it, in any direction.
  double sag = 0, change = 0;
  std::array<double, 3> share_N{};  // of the force at the tip, each joint's, at the instant of the fault
};

struct Sample {
  Eigen::Vector3d tip_m, velocity_m_s, on_hand_N;
  bool driven = false, armed = false;
  firmware::Fault fault = firmware::Fault::kNone;
  std::array<std::uint32_t, firmware::kJoints> counts{};  // of the encoders, as the board gave them
};
// What a sound arm does with this hand, and one without power. It depends on everything but the faults.
struct References {
  std::vector<Sample> sound, off;
};

// All throw std::runtime_error if the arm cannot be brought there.
[[nodiscard]] std::vector<Sample> sound_run(const Trial& trial);
[[nodiscard]] References references(const Trial& trial);
[[nodiscard]] Verdict judge(const Trial& trial, const References& references);
[[nodiscard]] inline Verdict judge(const Trial& trial) { return judge(trial, references(trial)); }
// The faulty run alone, not judged: fault, probes, sag and shares.
[[nodiscard]] Verdict look(const Trial& trial);

}  // namespace thimble::test
