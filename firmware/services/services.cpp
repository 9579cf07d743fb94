#include "firmware/services/services.h"

#include <array>

#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {
namespace {

using link::Routine;
using link::Service;
using link::Session;

enum class Sessions : std::uint8_t { kAll, kNotDefault, kProgramming };
// kKey: it must not be anybody's; kLease: it is a command (lease.h); kLeaseOfArm: of those that order the arm.
enum class Needs : std::uint8_t { kNothing, kKey, kLease, kLeaseOfArm };

[[nodiscard]] bool allows(Sessions sessions, Session session) noexcept {
  switch (sessions) {
    case Sessions::kAll:
      return true;
    case Sessions::kNotDefault:
      return session != Session::kDefault;
    case Sessions::kProgramming:
      return session == Session::kProgramming;
  }
  return false;
}

[[nodiscard]] Nrc grants(Services& services, Call& call, Needs needs) noexcept {
  switch (needs) {
    case Needs::kNothing:
      return Nrc::kOk;
    case Needs::kKey:
      return services.authenticator.allows(call.host) ? Nrc::kOk : Nrc::kAuthenticationRequired;
    case Needs::kLease:
    case Needs::kLeaseOfArm:
      return services.may_command(call, needs == Needs::kLeaseOfArm);
  }
  return Nrc::kGeneralReject;
}

using Handler = Nrc (*)(Services&, Call&) noexcept;

[[nodiscard]] Nrc routine_control(Services& services, Call& call) noexcept;

struct ServiceRow {
  Service service;
  Sessions sessions;
  Needs needs;
  Handler handle;
};
constexpr std::array<ServiceRow, 12> kServices = {{
    {Service::kSession, Sessions::kAll, Needs::kNothing, session_control},
    {Service::kReset, Sessions::kNotDefault, Needs::kLease, restart_board},
    {Service::kClearFaults, Sessions::kNotDefault, Needs::kLease, clear_faults},
    {Service::kReadFaults, Sessions::kAll, Needs::kNothing, read_faults},
    {Service::kReadData, Sessions::kAll, Needs::kNothing, read_data},
    {Service::kAuthentication, Sessions::kNotDefault, Needs::kNothing, authentication},
    {Service::kWriteData, Sessions::kNotDefault, Needs::kNothing, write_data},  // by the parameter
    {Service::kRoutine, Sessions::kAll, Needs::kNothing, routine_control},      // kRoutines says it of each
    {Service::kRequestDownload, Sessions::kProgramming, Needs::kLease, request_download},
    {Service::kTransferData, Sessions::kProgramming, Needs::kLease, transfer_data},
    {Service::kTransferExit, Sessions::kProgramming, Needs::kLease, transfer_exit},
    {Service::kTesterPresent, Sessions::kAll, Needs::kNothing, tester_present},
}};

constexpr std::uint8_t kStart = 0x01, kStop = 0x02, kResults = 0x03;
constexpr std::size_t kMoveOrder = link::wire_size<link::MoveOrder>();
constexpr std::size_t kAxisOrder = link::wire_size<link::AxisOrder>(),
                      kHomePlace = link::wire_size<link::HomePlace>();

struct RoutineRow {
  Routine routine;
  std::uint8_t action;
  Sessions sessions;
  Needs needs;
  std::size_t argument_bytes;
  Handler handle;
};
constexpr std::array<RoutineRow, 25> kRoutines = {{
    {Routine::kArm, kStart, Sessions::kNotDefault, Needs::kLeaseOfArm, 0, arm},
    {Routine::kDisarm, kStart, Sessions::kAll, Needs::kNothing, 0,
     disarm},  // never a question of the session
    {Routine::kHome, kStart, Sessions::kNotDefault, Needs::kLeaseOfArm, 0, home},
    {Routine::kActivate, kStart, Sessions::kNotDefault, Needs::kLease, 0, activate},
    {Routine::kPrepareDownload, kStart, Sessions::kProgramming, Needs::kLease, 8, prepare_download},
    {Routine::kPrepareArm, kStart, Sessions::kProgramming, Needs::kLease, 9, prepare_arm},
    {Routine::kActivateArm, kStart, Sessions::kNotDefault, Needs::kLease, 0, activate_arm},
    {Routine::kSaveParameters, kStart, Sessions::kNotDefault, Needs::kLease, 0, save_parameters},
    {Routine::kTellTime, kStart, Sessions::kNotDefault, Needs::kKey, 4, tell_time},
    {Routine::kKey, kStart, Sessions::kNotDefault, Needs::kLease, link::kKeyBytes, set_key},
    {Routine::kKey, kStop, Sessions::kNotDefault, Needs::kLease, 0, remove_key},
    {Routine::kCommand, kStart, Sessions::kNotDefault, Needs::kLease, 0, take_lease},
    {Routine::kCommand, kStop, Sessions::kNotDefault, Needs::kNothing, 0, give_back_lease},
    {Routine::kMove, kStart, Sessions::kNotDefault, Needs::kLeaseOfArm, kMoveOrder, start_move},
    {Routine::kMove, kStop, Sessions::kNotDefault, Needs::kNothing, 0, end_move},
    {Routine::kMove, kResults, Sessions::kNotDefault, Needs::kNothing, 0, move_results},
    {Routine::kAxes, kStart, Sessions::kNotDefault, Needs::kLeaseOfArm, kAxisOrder, start_axes},
    {Routine::kAxes, kStop, Sessions::kNotDefault, Needs::kNothing, 0, end_move},
    {Routine::kAxes, kResults, Sessions::kNotDefault, Needs::kNothing, 0, axes_results},
    {Routine::kHomeAt, kStart, Sessions::kNotDefault, Needs::kLeaseOfArm, kHomePlace, home_at},
    {Routine::kRecording, kStart, Sessions::kNotDefault, Needs::kLease, 0, start_recording},
    {Routine::kRecordCounts, kStart, Sessions::kNotDefault, Needs::kLease, 0, start_recording_counts},
    {Routine::kRecording, kStop, Sessions::kNotDefault, Needs::kNothing, 0, end_recording},
    {Routine::kRecording, kResults, Sessions::kNotDefault, Needs::kNothing, 0, recording_start},
    {Routine::kAudit, kResults, Sessions::kAll, Needs::kNothing, 4, audit_results},
}};

[[nodiscard]] bool known(std::uint16_t routine) noexcept {
  for (const RoutineRow& row : kRoutines)
    if (static_cast<std::uint16_t>(row.routine) == routine) return true;
  return false;
}

// 31 action routine(2) arguments.
Nrc routine_control(Services& services, Call& call) noexcept {
  const bool open = call.host.session != Session::kDefault;
  if (call.request.size() < kRoutineHeader) return open ? Nrc::kIncorrectLength : Nrc::kNotInThisSession;
  const std::uint8_t action = call.sub_function();
  const std::uint16_t routine = u16_at(call.request, 2);
  const std::span<const std::uint8_t> arguments = routine_arguments(call);
  call.answer.put(action);
  call.answer.put_u16(routine);
  for (const RoutineRow& row : kRoutines) {
    if (static_cast<std::uint16_t>(row.routine) != routine || row.action != action) continue;
    if (!allows(row.sessions, call.host.session)) return Nrc::kNotInThisSession;
    if (arguments.size() != row.argument_bytes) return Nrc::kIncorrectLength;
    const Nrc allowed = grants(services, call, row.needs);
    return allowed == Nrc::kOk ? row.handle(services, call) : allowed;
  }
  BoardRoutine* const inject = services.parts.config.inject;
  if (open && inject != nullptr && action == kStart &&
      routine == static_cast<std::uint16_t>(Routine::kInject))
    return inject->start(arguments) ? Nrc::kOk : Nrc::kRequestOutOfRange;
  if (!open && routine != static_cast<std::uint16_t>(Routine::kDisarm)) return Nrc::kNotInThisSession;
  if (known(routine) || action != kStart) return Nrc::kSubFunctionNotSupported;
  return arguments.empty() ? Nrc::kRequestOutOfRange : Nrc::kIncorrectLength;
}

}  // namespace

Services::Services(const ServiceParts& controller) noexcept
    : parts(controller),
      command(controller.core, controller.config.lacks),
      end_recording(controller.core),
      mark(controller.core),
      switch_scene(controller.core),
      download(controller.config.block_bytes),
      authenticator(controller.keys, controller.config.node_id) {}

Nrc Services::handle(Call& call) noexcept {
  now_us_ = call.now_us;
  if (!call.again) call.host.halts = parts.core.commands().halts();
  for (const ServiceRow& row : kServices) {
    if (static_cast<std::uint8_t>(row.service) != call.request[0]) continue;
    if (!allows(row.sessions, call.host.session)) return Nrc::kNotInThisSession;
    const Nrc allowed = grants(*this, call, row.needs);
    return allowed == Nrc::kOk ? row.handle(*this, call) : allowed;
  }
  return Nrc::kServiceNotSupported;
}

Nrc Services::may_command(Call& call, bool orders_arm) noexcept {
  if (call.again) return Nrc::kOk;  // the command was taken
  if (!authenticator.allows(call.host)) return Nrc::kAuthenticationRequired;
  switch (lease.take(call.host, call.now_us, parts.core.status().mode(), orders_arm)) {
    case Lease::Taken::kYes:
      return Nrc::kOk;
    case Lease::Taken::kNotYet:
      return busy(call.host, Busy::kOtherHostCommands);
    case Lease::Taken::kWhileArmed:
      call.host.refuse(kOtherHostsArm);
      return Nrc::kConditionsNotCorrect;
  }
  return Nrc::kGeneralReject;
}

const Host* Services::commander() const noexcept { return lease.holder(now_us_, parts.core.status().mode()); }

// Where it matters that the commanding host is alive, another one's requests do not show it, nor do they when it has vanished from an armed
// arm. One that has left it on purpose leaves it to whoever looks.
void Services::host_alive(const Host& host, link::Micros now) noexcept {
  const Mode mode = parts.core.status().mode();
  const Host* commands = lease.holder(now, mode);
  const link::StatusFlags flags = parts.status.flags();
  const bool matters = flags.supervised || flags.moves_itself;
  const bool anybodys = commands == nullptr && !(lease.vanished() && mode == Mode::kArmed);
  if (!matters || anybodys || commands == &host) parts.core.commands().keep_alive();
}

bool Services::urgent(std::span<const std::uint8_t> request) const noexcept {
  return request.size() == kRoutineHeader && request[0] == static_cast<std::uint8_t>(Service::kRoutine) &&
         (request[1] & static_cast<std::uint8_t>(~link::kSuppressPositive)) == kStart &&
         u16_at(request, 2) == static_cast<std::uint16_t>(Routine::kDisarm);
}

void Services::restart(link::Reset kind) noexcept {
  static_cast<void>(parts.core.commands().request(Command::kDisarm));
  restart_wanted = kind;
}

}  // namespace thimble::firmware
