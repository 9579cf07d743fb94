// The faults that the commissioning names, what a builder does about each, and which of them look alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::host {

enum class ArmFault : std::uint8_t {
  kLineIgnored,  // e-stop, dead man or watchdog does not take the enable away
  kNoise,        // an encoder counts at rest, or makes transitions that no encoder makes
  kEncoderSign,
  kMotorSign,
  kEncodersSwapped,
  kMotorsSwapped,
  kJointsSwapped,  // encoder and motor
  kWrongCounts,
  kWrongRatio,
  kDeadChannel,
  kDeadEncoder,
  kSlip,
  kIndexOff,
  kOpenWinding,
  kDeadPhase,
  kWeakMotor,
  kWrongInertia,
  kWrongResistance,
  kCurrentLoop,     // the current is not what was asked
  kNoMotion,        // the axis does not move, and its drive has its current
  kUneven,          // both signs differ
  kFeedsEnergy,     // damping does not damp
  kWrongDirection,  // a force that does not oppose the hand
  kWrongWeight,     // gravity is not as the file has it
  kStopElsewhere,   // the way from stop to stop is off by less than a fault would make it
  kNoRest,          // its weight turns the joint wherever it is let go
};

struct FaultText {
  ArmFault fault;
  std::string_view name;    // "encoder-sign"
  std::string_view what;    // for people; follows the name of the joint
  std::string_view remedy;  // what to do next
};
[[nodiscard]] std::span<const FaultText> fault_texts() noexcept;
[[nodiscard]] const FaultText& text_of(ArmFault fault);
[[nodiscard]] ArmFault fault_named(std::string_view name);  // std::out_of_range: there is none

// A number of the arm file that the measurement says is another one. pointer: "/axes/1/encoder/sign".
struct Correction {
  std::string pointer;
  double value = 0;
};

struct ArmFinding {
  ArmFault fault{};
  int axis = -1;                        // -1: of the whole arm
  int other = -1;                       // the second axis of an exchange
  double factor = 1;                    // true by given, where there is one
  std::vector<ArmFault> twins;          // what looks the same to the steps done so far
  std::vector<Correction> corrections;  // where the file may be what is wrong
  std::string text;                     // the whole sentence, with figures
};

}  // namespace thimble::host
