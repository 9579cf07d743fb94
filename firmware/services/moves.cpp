// Routine 0206: guarded moves (firmware/sources/guarded_move.h); routine 020F: orders for the axes (firmware/sources/axis_drive.h).
#include "firmware/services/handlers.h"
#include "firmware/sources/guarded_move_link.h"

namespace thimble::firmware {

Nrc start_move(Services& services, Call& call) noexcept {
  link::MoveOrder order;
  if (!link::decode(routine_arguments(call), order)) return Nrc::kIncorrectLength;
  const Nrc result = services.jobs.run(
      call, services.command, [&]() noexcept { return services.command.begin_move(call, from_link(order)); });
  if (result == Nrc::kOk)
    services.parts.audit.add(link::AuditEvent::kMove, call.host, call.now_us, 0, order.arm);
  return result;
}

// Out of line, so that the order is on the stack no longer than this takes.
[[gnu::noinline]] static Nrc begin_axes(Services& services, Call& call) noexcept {
  link::AxisOrder order;
  if (!link::decode(routine_arguments(call), order)) return Nrc::kIncorrectLength;
  return services.command.begin_axes(call, order);
}

Nrc start_axes(Services& services, Call& call) noexcept {
  const Nrc result =
      services.jobs.run(call, services.command, [&]() noexcept { return begin_axes(services, call); });
  if (result == Nrc::kOk)
    services.parts.audit.add(link::AuditEvent::kMove, call.host, call.now_us, 1, routine_arguments(call)[0]);
  return result;
}

Nrc axes_results(Services& services, Call& call) noexcept {
  call.answer.put_record(services.parts.core.sources().axes.state());
  return Nrc::kOk;
}

Nrc end_move(Services& services, Call& call) noexcept {
  return services.jobs.run(call, services.command,
                           [&]() noexcept { return services.command.begin(call, Command::kEndMove); });
}

Nrc move_results(Services& services, Call& call) noexcept {
  const MoveResults* results = services.parts.core.sources().move.results();
  if (results == nullptr) return Nrc::kRequestSequenceError;  // it is under way
  for (const MoveSample& sample : results->going.samples())
    call.answer.put_record(to_link(link::MovePhase::kGoing, sample));
  for (const MoveSample& sample : results->coming_back.samples())
    call.answer.put_record(to_link(link::MovePhase::kComingBack, sample));
  return Nrc::kOk;
}

link::MoveState move_state(const Core& core) noexcept {
  link::MoveState state;
  state.phase = core.sources().move.phase();
  state.end = core.sources().move.end();
  if (const MoveResults* results = core.sources().move.results()) {
    state.samples =
        static_cast<std::uint16_t>(results->going.samples().size() + results->coming_back.samples().size());
    state.turn_x_m = results->turn_m.x();
    state.turn_y_m = results->turn_m.y();
    state.turn_z_m = results->turn_m.z();
    state.peak_force_N = results->peak_force_N;
    state.friction_N = results->friction_N;
  }
  return state;
}

}  // namespace thimble::firmware
