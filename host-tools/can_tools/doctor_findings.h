// Judges the facts: for each item its state, the cause, and the command that repairs it. No I/O, so tests cover every case without a
// CAN interface.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host-tools/can_tools/doctor_facts.h"
#include "host-tools/error.h"

namespace thimble::host {

enum class FindingState { kOk, kWarning, kFailure };

struct Finding {
  std::string name;     // what was looked at or is wrong, a slug: "queue", "bus-off"
  std::string subject;  // an interface or a device; may be empty
  FindingState state = FindingState::kOk;
  std::string cause;              // one sentence
  std::string remedy;             // the command to type; empty if nothing is to be done
  ExitCode code = ExitCode::kOk;  // of a failure
};

// What the user means to use: one of the two, or nothing.
struct Wish {
  std::string interface;
  bool fd = false;
  std::string port;
  bool board = false;  // thimble-board is to run here
};

// What the user's choice lacks is a failure; what other interfaces lack is a warning.
[[nodiscard]] std::vector<Finding> judge(const Facts& facts, const Wish& wish);

[[nodiscard]] std::string_view state_name(FindingState state);  // "ok", "warning", "failure"

}  // namespace thimble::host
