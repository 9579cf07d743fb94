#include "firmware/services/jobs.h"

#include "firmware/services/refusal.h"

namespace thimble::firmware {

Nrc CommandJob::begin(Call& call, Command command) noexcept {
  call.host.refuse("");
  if (yields(call, command)) return refuse(call.host, kWrongMode, lacks_);
  return begun(call, command, core_.commands().request(command));
}

Nrc CommandJob::begin_guest(Call& call, auto&& post) noexcept {
  if (yields(call, Command::kMove)) return refuse(call.host, kWrongMode, lacks_);
  if (core_.commands().pending() && !core_.commands().disarm_due())
    return busy(call.host, Busy::kCommandPending);
  return begun(call, Command::kMove, post());
}

Nrc CommandJob::begin_move(Call& call, const MoveOrder& order) noexcept {
  call.host.refuse("");
  if (!core_.commands().move_in_range(order)) return Nrc::kRequestOutOfRange;
  return begin_guest(call, [&]() noexcept { return core_.commands().request_move(order); });
}

Nrc CommandJob::begin_axes(Call& call, const link::AxisOrder& order) noexcept {
  call.host.refuse("");
  if (!core_.commands().axes_in_range(order)) return Nrc::kRequestOutOfRange;
  return begin_guest(call, [&]() noexcept { return core_.commands().request_axes(order); });
}

// A stop or a disarm that came after the request goes before it, also where the request had to wait for another host's.
bool CommandJob::yields(const Call& call, Command command) const noexcept {
  return (yields_to_disarm(command) || yields_to_stop(command)) &&
         core_.commands().halts() != call.host.halts;
}

Nrc CommandJob::begun(Call& call, Command command, Conditions against) noexcept {
  if (against != 0) return refuse(call.host, against, lacks_);
  command_ = command;
  return Nrc::kResponsePending;
}

Nrc CommandJob::poll(Call& call) noexcept {
  if (core_.commands().pending()) return Nrc::kResponsePending;
  if (done() && (yields_to_stop(command_) || !yields(call, command_))) return Nrc::kOk;
  // Something came between the check and the tick.
  const Conditions against =
      command_ == Command::kMove ? core_.status().unmet_for_move() : core_.status().unmet();
  return refuse(call.host, against != 0 ? against : Conditions{kWrongMode},
                lacks_);  // 0: another command came after it
}

bool CommandJob::done() const noexcept {
  const Mode mode = core_.status().mode();
  switch (command_) {
    case Command::kArm:
      return mode == Mode::kArmed;
    case Command::kHome:
      return mode == Mode::kHoming ||
             (mode == Mode::kReady && (core_.status().unmet_of_tick() & kNotHomed) == 0);
    case Command::kMove:
      return core_.sources().guest_leads();
    case Command::kEndMove:
      return !core_.sources().guest_leads();
    case Command::kRecord:
      return core_.observers().recorder.phase() == RecordingPhase::kRunning;
    case Command::kNone:
    case Command::kDisarm:
    case Command::kClear:
    case Command::kStop:
      return core_.status().fault() == Fault::kNone;
  }
  return false;
}

Nrc EndRecordingJob::begin(RecordingEnd reason) noexcept {
  if (core_.observers().recorder.phase() != RecordingPhase::kRunning) return Nrc::kOk;
  core_.observers().recorder.request_end(reason);
  return Nrc::kResponsePending;
}

Nrc EndRecordingJob::poll(Call& /*call*/) noexcept {
  const Recorder& recorder = core_.observers().recorder;
  const bool waits = recorder.phase() == RecordingPhase::kRunning && recorder.end_pending();
  return waits ? Nrc::kResponsePending : Nrc::kOk;
}

namespace {

link::MarkKind mark_kind(const ParamRow& row) noexcept {
  return row.id == row_of(Param::trial).id ? link::MarkKind::kTrial : link::MarkKind::kEvent;
}

}  // namespace

bool post_mark(Core& core, const Params& params, const ParamRow& row, std::uint32_t bits) noexcept {
  std::uint32_t before = 0;
  static_cast<void>(params.read(row.id, before));
  return core.marks().post(
      {mark_kind(row), static_cast<std::uint16_t>(bits), static_cast<std::uint16_t>(before)});
}

Nrc MarkJob::begin(Call& call, Params& params, const ParamRow& row, std::uint32_t bits) noexcept {
  call.host.refuse("");
  if (!post_mark(core_, params, row, bits)) return busy(call.host, Busy::kCommandPending);
  static_cast<void>(params.write(row.id, bits, true));  // one that may be written at any time
  call.host.marked.what = mark_kind(row);
  call.host.marked.value = static_cast<std::uint16_t>(bits);
  return Nrc::kResponsePending;
}

Nrc MarkJob::poll(Call& call) noexcept {
  if (core_.marks().pending()) return Nrc::kResponsePending;
  ++call.host.marked.count;
  call.host.marked.tick = core_.marks().tick();
  return Nrc::kOk;
}

Nrc SwitchSceneJob::poll(Call& /*call*/) noexcept {
  return core_.sources().scene.pending() ? Nrc::kResponsePending : Nrc::kOk;
}

}  // namespace thimble::firmware
