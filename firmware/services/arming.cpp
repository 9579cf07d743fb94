// Routines 0201 (arm), 0202 (disarm), 0203 (home).
#include "firmware/services/handlers.h"

namespace thimble::firmware {

// A live link is a condition for arming, so arming itself is no sign of life.
Nrc arm(Services& services, Call& call) noexcept {
  call.sign_of_life = false;
  return services.jobs.run(call, services.command,
                           [&]() noexcept { return services.command.begin(call, Command::kArm); });
}

// No job: it waits for nothing and nobody, and it replaces a command that the tick has not taken yet.
Nrc disarm(Services& services, Call& /*call*/) noexcept {
  static_cast<void>(services.parts.core.commands().request(Command::kDisarm));
  return Nrc::kOk;
}

// kOk: homing has begun; the mode tells when it is done.
Nrc home(Services& services, Call& call) noexcept {
  return services.jobs.run(call, services.command,
                           [&]() noexcept { return services.command.begin(call, Command::kHome); });
}

}  // namespace thimble::firmware
