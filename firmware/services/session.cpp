// Services 10 (session), 11 (restart), 3E (tester present); routine 020C (the lease).
#include "firmware/services/handlers.h"

namespace thimble::firmware {

using link::Reset;
using link::Session;

Nrc session_control(Services& services, Call& call) noexcept {
  if (call.request.size() != 2) return Nrc::kIncorrectLength;
  const auto session = static_cast<Session>(call.sub_function());
  if (session != Session::kDefault && session != Session::kProgramming && session != Session::kExtended)
    return Nrc::kSubFunctionNotSupported;
  if (session == Session::kProgramming && call.host.session == Session::kProgramming) {
    services.download.start_over(call.host);  // a host that resumes an upload begins so
  } else {
    services.download.end(call.host);
  }
  if (session == Session::kDefault) services.lease.end(call.host);
  call.host.session = session;
  call.answer.put(static_cast<std::uint8_t>(session));
  call.answer.put_u16(50);   // P2 in ms: an answer comes within
  call.answer.put_u16(500);  // P2* in 10 ms: after a "response pending"
  return Nrc::kOk;
}

// Routine 020C. The table has taken it already.
Nrc take_lease(Services& /*services*/, Call& /*call*/) noexcept { return Nrc::kOk; }

Nrc give_back_lease(Services& services, Call& call) noexcept {
  services.lease.end(call.host);
  return Nrc::kOk;
}

Nrc restart_board(Services& services, Call& call) noexcept {
  if (call.request.size() != 2) return Nrc::kIncorrectLength;
  const auto kind = static_cast<Reset>(call.sub_function());
  if (kind != Reset::kHard && kind != Reset::kSoft) return Nrc::kSubFunctionNotSupported;
  call.host.restart = kind;
  services.parts.audit.add(link::AuditEvent::kRestart, call.host, call.now_us);
  services.parts.audit.asked(Audit::Asked::kDisarm, call.host, call.now_us);  // Services::restart()
  call.answer.put(static_cast<std::uint8_t>(kind));
  return Nrc::kOk;
}

Nrc tester_present(Services& /*services*/, Call& call) noexcept {
  if (call.request.size() != 2) return Nrc::kIncorrectLength;
  if (call.sub_function() != 0) return Nrc::kSubFunctionNotSupported;
  call.answer.put(0);
  return Nrc::kOk;
}

}  // namespace thimble::firmware
