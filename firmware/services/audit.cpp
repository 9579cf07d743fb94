// What the audit record tells; service 31 03 020A (read it).
#include "firmware/services/audit.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "firmware/services/handlers.h"

namespace thimble::firmware {

using link::AuditEvent;
using link::Micros;

void Audit::start(const char* reset_reason) noexcept {
  log_.open(persistent_.starts());
  Who reason;
  std::copy_n(reset_reason, std::min(std::strlen(reset_reason), reason.name.size()), reason.name.begin());
  add(AuditEvent::kStart, reason, {persistent_.utc_at_start(), 0});
}

Audit::Who Audit::take(Asked what) noexcept {
  return std::exchange(asked_[static_cast<std::size_t>(what)], {});
}

void Audit::add(AuditEvent event, const Who& who, AuditLog::Time now, std::uint32_t value,
                std::uint16_t detail) noexcept {
  link::AuditRecord entry;
  entry.event = event;
  entry.host = who.host;
  entry.value = value;
  entry.detail = detail;
  std::copy(who.name.begin(), who.name.end(), entry.text.begin());
  log_.add(std::move(entry), now);
}

void Audit::add(AuditEvent event, const Host& host, Micros now, std::uint32_t value,
                std::uint16_t detail) noexcept {
  add(event, Who{host.address, host.name}, time(now), value, detail);
}

void Audit::asked(Asked what, const Host& host, Micros now) noexcept {
  observe(now);
  asked_[static_cast<std::size_t>(what)] = {host.address, host.name};
}

// The mode is read first: the rest is then of the same tick, or of a later one.
void Audit::observe(Micros now) noexcept {
  const Status& status = core_.status();
  const Mode mode = status.mode();
  const Fault fault = status.fault();
  const std::uint32_t fault_tick = status.fault_tick();
  const bool other_fault = fault != fault_ || (fault != Fault::kNone && fault_tick != fault_tick_);
  // It may have been armed and braked since.
  const bool armed =
      mode_ != Mode::kArmed && (mode == Mode::kArmed || (mode == Mode::kDamping && !motors_on(mode_)));
  const bool disarmed = mode != Mode::kArmed && (armed || mode_ == Mode::kArmed);
  if (other_fault && fault_ != Fault::kNone)
    add(AuditEvent::kCleared, take(Asked::kClear), time(now), static_cast<std::uint32_t>(fault_));
  if (armed) add(AuditEvent::kArmed, take(Asked::kArm), time(now));
  if (other_fault && fault != Fault::kNone)
    add(AuditEvent::kFault, Who{}, time(now), static_cast<std::uint32_t>(fault));
  if (disarmed) {
    const link::StoppedBy cause = status.stopped_by();
    const bool by_host = cause == link::StoppedBy::kDisarm;
    add(AuditEvent::kDisarmed, by_host ? take(Asked::kDisarm) : Who{}, time(now),
        static_cast<std::uint32_t>(fault), static_cast<std::uint16_t>(cause));
  }
  mode_ = mode;
  fault_ = fault;
  fault_tick_ = fault_tick;
}

void Audit::poll(Micros now, bool restarts) noexcept {
  observe(now);
  log_.poll(time(now), !motors_on(mode_));
  finished_ = restarts && !motors_on(mode_) && log_.finish(time(now));
}

// 31 03 020A from(4).
Nrc audit_results(Services& services, Call& call) noexcept {
  services.parts.audit.log().read(u32_at(routine_arguments(call), 0), call.answer);
  return Nrc::kOk;
}

}  // namespace thimble::firmware
