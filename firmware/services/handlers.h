// The handlers: one for each service, and one for each routine and action of service 31. Each reads the request, executes it
// or begins a job, appends its answer, and returns the response code that the router sends (call.h).
#pragma once

#include "firmware/services/services.h"

namespace thimble::firmware {

// session.cpp
[[nodiscard]] Nrc session_control(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc restart_board(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc tester_present(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc take_lease(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc give_back_lease(Services& services, Call& call) noexcept;
// authenticator.cpp
[[nodiscard]] Nrc authentication(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc set_key(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc remove_key(Services& services, Call& call) noexcept;
// identification.cpp
[[nodiscard]] Nrc read_data(Services& services, Call& call) noexcept;
// jobs.cpp: of a parameter for which marks() is true. False: no tick has taken the last mark yet.
[[nodiscard]] bool post_mark(Core& core, const Params& params, const ParamRow& row,
                             std::uint32_t bits) noexcept;
// parameters.cpp
[[nodiscard]] Nrc read_parameter(const Services& services, std::uint16_t id,
                                 link::ByteWriter& answer) noexcept;
[[nodiscard]] Nrc write_data(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc save_parameters(Services& services, Call& call) noexcept;
[[nodiscard]] bool motors_off(const Core& core) noexcept;
[[nodiscard]] Nrc tell_time(Services& services, Call& call) noexcept;
// audit.cpp
[[nodiscard]] Nrc audit_results(Services& services, Call& call) noexcept;
// faults.cpp
[[nodiscard]] Nrc clear_faults(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc read_faults(Services& services, Call& call) noexcept;
// arming.cpp
[[nodiscard]] Nrc arm(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc disarm(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc home(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc home_at(Services& services, Call& call) noexcept;
// download.cpp
[[nodiscard]] Nrc prepare_download(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc prepare_arm(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc activate_arm(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc request_download(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc transfer_data(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc transfer_exit(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc activate(Services& services, Call& call) noexcept;
// moves.cpp
[[nodiscard]] Nrc start_move(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc end_move(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc move_results(Services& services, Call& call) noexcept;
[[nodiscard]] link::MoveState move_state(const Core& core) noexcept;
[[nodiscard]] Nrc start_axes(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc axes_results(Services& services, Call& call) noexcept;
// recording.cpp
[[nodiscard]] Nrc start_recording(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc start_recording_counts(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc end_recording(Services& services, Call& call) noexcept;
[[nodiscard]] Nrc recording_start(Services& services, Call& call) noexcept;

inline constexpr std::size_t kRoutineHeader = 4;  // of a request: service, action, routine
[[nodiscard]] inline std::span<const std::uint8_t> routine_arguments(const Call& call) noexcept {
  return call.request.subspan(kRoutineHeader);
}

}  // namespace thimble::firmware
