// Emulated drives and their faults from text, for the command line of thimble-sim-drive. Throws std::invalid_argument with what is wrong.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "board/sim/drives/emulated_drive.h"

namespace thimble::board::emulated {

// "KIND:ID[:REPLY_ID[:TORQUE_N_M]]"; kinds: moteus, odrive05, odrive06, mini-cheetah, cubemars, damiao, damiao-fd. In MIT mode the torque's codes
// go to TORQUE_N_M, without it to that of a usual motor of the kind; without a reply id it is ID + 16.
struct NamedDrive {
  std::unique_ptr<EmulatedDrive> drive;
  bool fd = false;
};
[[nodiscard]] NamedDrive parse_drive(const std::string& text);

// "TIME_S:DRIVE:FAULT[=VALUE]", DRIVE counts from 0: what happens to it, once, at a time after the start.
struct TimedFault {
  double time_s = 0;
  std::size_t drive = 0;
  std::function<void(EmulatedDrive&)> happens;
};
[[nodiscard]] TimedFault parse_fault(const std::string& text);
[[nodiscard]] std::string fault_names();

}  // namespace thimble::board::emulated
