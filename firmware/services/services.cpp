#include "firmware/services/services.h"

#include <array>

#include "firmware/services/handlers.h"

namespace thimble::firmware {
namespace {

using link::Routine;
using link::Service;
using link::Session;

enum class Sessions : std::uint8_t { kAll, kNotDefault, kProgramming };

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

using Handler = Nrc (*)(Services&, Call&) noexcept;

[[nodiscard]] Nrc routine_control(Services& services, Call& call) noexcept;

struct ServiceRow {
  Service service;
  Sessions sessions;
  Handler handle;
};
constexpr std::array<ServiceRow, 11> kServices = {{
    {Service::kSession, Sessions::kAll, session_control},
    {Service::kReset, Sessions::kNotDefault, restart_board},
    {Service::kClearFaults, Sessions::kNotDefault, clear_faults},
    {Service::kReadFaults, Sessions::kAll, read_faults},
    {Service::kReadData, Sessions::kAll, read_data},
    {Service::kWriteData, Sessions::kNotDefault, write_data},
    {Service::kRoutine, Sessions::kAll, routine_control},  // kRoutines says in which sessions each works
    {Service::kRequestDownload, Sessions::kProgramming, request_download},
    {Service::kTransferData, Sessions::kProgramming, transfer_data},
    {Service::kTransferExit, Sessions::kProgramming, transfer_exit},
    {Service::kTesterPresent, Sessions::kAll, tester_present},
}};

constexpr std::uint8_t kStart = 0x01, kStop = 0x02, kResults = 0x03;
constexpr std::size_t kMoveOrder = link::wire_size<link::MoveOrder>();

struct RoutineRow {
  Routine routine;
  std::uint8_t action;
  Sessions sessions;
  std::size_t argument_bytes;
  Handler handle;
};
constexpr std::array<RoutineRow, 14> kRoutines = {{
    {Routine::kArm, kStart, Sessions::kNotDefault, 0, arm},
    {Routine::kDisarm, kStart, Sessions::kAll, 0, disarm},  // never a question of the session
    {Routine::kHome, kStart, Sessions::kNotDefault, 0, home},
    {Routine::kActivate, kStart, Sessions::kNotDefault, 0, activate},
    {Routine::kPrepareDownload, kStart, Sessions::kProgramming, 8, prepare_download},
    {Routine::kSaveParameters, kStart, Sessions::kNotDefault, 0, save_parameters},
    {Routine::kTellTime, kStart, Sessions::kNotDefault, 4, tell_time},
    {Routine::kMove, kStart, Sessions::kNotDefault, kMoveOrder, start_move},
    {Routine::kMove, kStop, Sessions::kNotDefault, 0, end_move},
    {Routine::kMove, kResults, Sessions::kNotDefault, 0, move_results},
    {Routine::kRecording, kStart, Sessions::kNotDefault, 0, start_recording},
    {Routine::kRecording, kStop, Sessions::kNotDefault, 0, end_recording},
    {Routine::kRecording, kResults, Sessions::kNotDefault, 0, recording_start},
    {Routine::kAudit, kResults, Sessions::kAll, 4, audit_results},
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
    return arguments.size() == row.argument_bytes ? row.handle(services, call) : Nrc::kIncorrectLength;
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
      switch_scene(controller.core),
      download(controller.config.block_bytes) {}

Nrc Services::handle(Call& call) noexcept {
  if (!call.again) call.host.disarms = parts.core.commands().disarms();
  for (const ServiceRow& row : kServices) {
    if (static_cast<std::uint8_t>(row.service) != call.request[0]) continue;
    return allows(row.sessions, call.host.session) ? row.handle(*this, call) : Nrc::kNotInThisSession;
  }
  return Nrc::kServiceNotSupported;
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
