// Service 2E (write: parameters, the name of a host), the parameters' part of 22 (read), routines 0207 (save), 0209 (tell the time).
#include <algorithm>
#include <bit>
#include <cmath>

#include "firmware/core/stop_timeout.h"
#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {
namespace {

constexpr std::size_t kParamBytes = 4;

// The stop path would have to wait for longer than it may. A value that is no greater than the present one makes nothing worse.
[[nodiscard]] bool stops_too_late(const ServiceParts& parts, std::uint16_t id, std::uint32_t bits) noexcept {
  if (id != row_of(Param::lost_ticks).id || bits <= parts.params.get_unsigned(Param::lost_ticks))
    return false;
  return !stop_timeout_us(static_cast<std::uint32_t>(std::lround(parts.config.period_s * 1e9F)), bits);
}

// kOk for kOk.
[[nodiscard]] Nrc refuse_param(Host& host, ParamStatus status) noexcept {
  switch (status) {
    case ParamStatus::kOk:
      return Nrc::kOk;
    case ParamStatus::kUnknown:
    case ParamStatus::kOutOfRange:
      return Nrc::kRequestOutOfRange;
    case ParamStatus::kNotWhileArmed:
      return refuse(host, kWrongMode, "");
    case ParamStatus::kBusy:
      return busy(host, Busy::kCommandPending);
  }
  return Nrc::kGeneralReject;
}

// Anybody may write what no force depends on, and may lower the maximum force.
[[nodiscard]] bool is_command(const Params& params, const ParamRow& row, std::uint32_t bits) noexcept {
  const bool lowers =
      row.id == row_of(Param::max_force).id && std::bit_cast<float>(bits) <= params.get(Param::max_force);
  return has_effect_on_forces(row) && !lowers;
}

// Printable ASCII only, so that whoever shows it need not look.
[[nodiscard]] Nrc name_host(Host& host, std::span<const std::uint8_t> name) noexcept {
  if (name.empty() || name.size() > host.name.size()) return Nrc::kIncorrectLength;
  if (!std::all_of(name.begin(), name.end(), [](std::uint8_t byte) { return byte >= 0x20 && byte < 0x7F; }))
    return Nrc::kRequestOutOfRange;
  host.name = {};
  std::copy(name.begin(), name.end(), host.name.begin());
  return Nrc::kOk;
}

}  // namespace

bool motors_off(const Core& core) noexcept {
  const Mode now = core.status().mode();
  return now != Mode::kArmed && now != Mode::kDamping && !core.commands().pending();
}

Nrc read_parameter(const Services& services, std::uint16_t id, link::ByteWriter& answer) noexcept {
  std::uint32_t bits = 0;
  if (services.parts.params.read(id, bits) != ParamStatus::kOk) return Nrc::kRequestOutOfRange;
  for (std::size_t i = 0; i < kParamBytes; ++i) answer.put(static_cast<std::uint8_t>(bits >> (8 * i)));
  return Nrc::kOk;
}

// 2E did(2) value. The tick may read a parameter at any time, so a recording that contains it ends first; but for a mark, which the host
// then reads with the tick that took it (Marked). An experiment has thousands of marks: they are no audit entries.
Nrc write_data(Services& services, Call& call) noexcept {
  if (call.request.size() < 4) return Nrc::kIncorrectLength;
  const std::uint16_t id = u16_at(call.request, 1);
  const std::span<const std::uint8_t> value = call.request.subspan(3);
  call.answer.put_u16(id);
  if (id == link::kDidHostName) return name_host(call.host, value);
  const ParamRow* row = find_param(id);
  if (row == nullptr) return Nrc::kRequestOutOfRange;
  if (value.size() != kParamBytes) return Nrc::kIncorrectLength;
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < kParamBytes; ++i) bits |= static_cast<std::uint32_t>(value[i]) << (8 * i);

  ServiceParts& parts = services.parts;
  if (is_command(parts.params, *row, bits)) {
    const Nrc allowed = services.may_command(call);
    if (allowed != Nrc::kOk) return allowed;
  }
  if (id == row_of(Param::telemetry_fd).id && bits != 0 && parts.config.classic_can) {
    call.host.refuse("bus_without_can_fd");
    return Nrc::kConditionsNotCorrect;
  }
  if (id == row_of(Param::max_force).id && !motors_off(parts.core) &&
      too_strong(parts.core.setup(), parts.params, std::bit_cast<float>(bits)))
    return refuse(call.host, kNotCommissioned, "");
  if (stops_too_late(parts, id, bits)) {
    call.host.refuse(kLacksShortStop);
    return Nrc::kConditionsNotCorrect;
  }
  if (marks(*row)) {
    return services.jobs.run(call, services.mark, [&]() noexcept {
      const Nrc allowed = refuse_param(call.host, parts.params.check(id, bits, true));
      return allowed != Nrc::kOk ? allowed : services.mark.begin(call, parts.params, *row, bits);
    });
  }
  if (row->recorded == Recording::kRecorded) {
    const Nrc ended = services.jobs.run(call, services.end_recording, [&]() noexcept {
      const Nrc allowed = refuse_param(call.host, parts.params.check(id, bits, motors_off(parts.core)));
      if (allowed != Nrc::kOk) return allowed;
      // It may be the start of a recording.
      if (parts.core.commands().pending()) return busy(call.host, Busy::kCommandPending);
      return services.end_recording.begin(RecordingEnd::kParameter);
    });
    if (ended != Nrc::kOk) return ended;
  }
  const ParamStatus written = parts.params.write(id, bits, motors_off(parts.core));
  if (written == ParamStatus::kOk && row->recorded == Recording::kRecorded)
    parts.audit.add(link::AuditEvent::kParameter, call.host, call.now_us, bits, id);
  return refuse_param(call.host, written);
}

Nrc save_parameters(Services& services, Call& call) noexcept {
  call.host.refuse("");
  if (!motors_off(services.parts.core)) return refuse(call.host, kWrongMode, "");
  const StoreStatus saved = services.parts.param_store.save(services.parts.params);
  if (saved == StoreStatus::kOk)
    services.parts.audit.add(link::AuditEvent::kSaved, call.host, call.now_us,
                             services.parts.param_store.crc());
  return refuse(call.host, saved);
}

// Routine 0209.
Nrc tell_time(Services& services, Call& call) noexcept {
  PersistentState& persistent = services.parts.persistent;
  const std::uint32_t told_s = u32_at(call.request, kRoutineHeader), before_s = persistent.utc_s(call.now_us);
  persistent.tell_time(told_s, call.now_us);
  if (persistent.utc_s(call.now_us) - before_s > PersistentState::kClockError_s)
    services.parts.audit.add(link::AuditEvent::kTimeTold, call.host, call.now_us, told_s);
  return Nrc::kOk;
}

}  // namespace thimble::firmware
