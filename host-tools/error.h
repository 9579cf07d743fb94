// The one error of the host tools: every failure that a user sees has a name, a cause and a remedy, and an
// exit code.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace thimble::host {

// Documented in docs/cli.md; tested one by one.
enum class ExitCode : int {
  kOk = 0,
  kRefused = 1,  // the device refused, or the operation failed
  kUsage = 2,
  kNotFound = 3,   // no device
  kAmbiguous = 4,  // several devices
  kPermission = 5,
  kLinkLost = 6,      // lost or timed out
  kVersion = 7,       // version mismatch
  kVerification = 8,  // verification failed
  kFaulted = 9,       // the device is faulted
  kBadInput = 10,     // bad input file
  kNotStopped = 11,   // a stop was not confirmed
  kCommanded = 12,    // another program commands the device
};

class Error : public std::runtime_error {
 public:
  // slug: a short stable slug ("unknown-key"); why: one sentence with file, place and value; what_to_do: the
  // remedy.
  Error(ExitCode exit_code, std::string slug, std::string why, std::string what_to_do)
      : std::runtime_error(why),
        code(exit_code),
        name(std::move(slug)),
        cause(std::move(why)),
        remedy(std::move(what_to_do)) {}

  ExitCode code;
  std::string name;
  std::string cause;
  std::string remedy;
};

}  // namespace thimble::host
