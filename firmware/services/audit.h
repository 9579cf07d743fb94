// Of what there is an entry in the audit record (firmware/store/audit_log.h), and who is named in it. Data goes one way: the services tell what
// a host did or asked for, the status of the tick tells what came of it. Called from the background.
//
// That the motors went on or off, and faults, are seen in the status: so an entry is there whatever was the cause, and whether or not the
// host waited for its answer. All else the services tell where it succeeds. What a program does that holds the controller has no entry.
//
// A host is named by its address on the link and by the name that it gave itself. Neither proves who it is.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/core.h"
#include "firmware/services/call.h"
#include "firmware/store/audit_log.h"
#include "firmware/store/persistent_state.h"

namespace thimble::firmware {

class Audit {
 public:
  enum class Asked : std::uint8_t { kArm, kDisarm, kClear };

  Audit(Storage& storage, const Core& core, PersistentState& persistent) noexcept
      : log_(storage), core_(core), persistent_(persistent) {}

  // Once, when the persistent state has been read.
  void start(const char* reset_reason) noexcept;
  // Before frames are handled, and in each poll: what has changed in the status.
  void observe(link::Micros now) noexcept;
  // restarts: as soon as finished() says so.
  void poll(link::Micros now, bool restarts) noexcept;
  // As of the last poll: a restart leaves no event behind (AuditLog::finish()).
  [[nodiscard]] bool finished() const noexcept { return finished_; }

  // Before the request is posted to the tick: who is to be named if it has an effect.
  void asked(Asked what, const Host& host, link::Micros now) noexcept;
  void add(link::AuditEvent event, const Host& host, link::Micros now, std::uint32_t value = 0,
           std::uint16_t detail = 0) noexcept;

  [[nodiscard]] const AuditLog& log() const noexcept { return log_; }

 private:
  struct Who {
    std::uint8_t host = 0;
    std::array<char, link::kHostNameBytes> name{};
  };
  [[nodiscard]] Who take(Asked what) noexcept;
  void add(link::AuditEvent event, const Who& who, AuditLog::Time now, std::uint32_t value = 0,
           std::uint16_t detail = 0) noexcept;
  [[nodiscard]] AuditLog::Time time(link::Micros now) noexcept {
    return {persistent_.utc_s(now), persistent_.up_s(now)};
  }

  AuditLog log_;
  const Core& core_;
  PersistentState& persistent_;
  std::array<Who, 3> asked_{};  // by Asked
  // As of the last observe().
  Mode mode_ = Mode::kDisarmed;
  Fault fault_ = Fault::kNone;
  std::uint32_t fault_tick_ = 0;
  bool finished_ = false;
};

}  // namespace thimble::firmware
