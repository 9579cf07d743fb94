// Routines 0201 (arm), 0202 (disarm), 0203 (home), 0210 (home where the host says).
#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {
namespace {

[[nodiscard]] Nrc audited_home(Services& services, Call& call, auto&& begin) noexcept {
  const Nrc result = services.jobs.run(call, services.command, begin);
  if (result == Nrc::kOk) services.parts.audit.add(link::AuditEvent::kHoming, call.host, call.now_us);
  return result;
}

}  // namespace

// A live link is a condition for arming, so arming itself is no sign of life.
Nrc arm(Services& services, Call& call) noexcept {
  call.sign_of_life = false;
  return services.jobs.run(call, services.command, [&]() noexcept {
    if (services.restart_wanted) return busy(call.host, Busy::kRestarting);
    services.parts.audit.asked(Audit::Asked::kArm, call.host, call.now_us);
    return services.command.begin(call, Command::kArm);
  });
}

// No job: it waits for no other host, and any number of hosts can wait for it. The answer comes after the tick that has obeyed it; at
// once where nothing is armed, homing, or about to be.
Nrc disarm(Services& services, Call& call) noexcept {
  Commands& commands = services.parts.core.commands();
  if (!call.host.disarming) {
    const bool pending = commands.pending();  // before the mode: a tick may come between
    const Mode mode = services.parts.core.status().mode();
    const bool rests = mode != Mode::kArmed && mode != Mode::kHoming && !pending;
    services.parts.audit.asked(Audit::Asked::kDisarm, call.host, call.now_us);
    static_cast<void>(commands.request(Command::kDisarm));
    if (rests) return Nrc::kOk;
  }
  call.host.disarming = commands.disarm_due();
  return call.host.disarming ? Nrc::kResponsePending : Nrc::kOk;
}

// kOk: homing has begun; the mode tells when it is done.
Nrc home(Services& services, Call& call) noexcept {
  return audited_home(services, call, [&]() noexcept {
    services.parts.core.commands().forget_place();
    return services.command.begin(call, Command::kHome);
  });
}

Nrc home_at(Services& services, Call& call) noexcept {
  return audited_home(services, call, [&]() noexcept {
    Commands& commands = services.parts.core.commands();
    link::HomePlace place;
    if (commands.pending()) return busy(call.host, Busy::kCommandPending);
    if (!link::decode(routine_arguments(call), place)) return Nrc::kIncorrectLength;
    if (!commands.place(place)) return Nrc::kRequestOutOfRange;
    const Nrc begun = services.command.begin(call, Command::kHome);
    if (begun != Nrc::kResponsePending) commands.forget_place();
    return begun;
  });
}

}  // namespace thimble::firmware
