// Routines 0208 and 0211: recordings (firmware/observe/recorder.h).
#include "firmware/link/bus_cost.h"
#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {

namespace {

Nrc begin_recording(Services& services, Call& call, bool counts_only) noexcept {
  ServiceParts& parts = services.parts;
  return services.jobs.run(call, services.command, [&]() noexcept {
    if (parts.core.sources().scene.pending()) return busy(call.host, Busy::kSceneSwitching);
    if (parts.core.observers().recorder.phase() == RecordingPhase::kRunning) {
      call.host.refuse("recording_runs");
      return Nrc::kConditionsNotCorrect;
    }
    if (!link::recording_fits(parts.config.arm_count, kJoints, 1.0F / parts.config.period_s,
                              parts.config.bus_bits_per_s)) {
      call.host.refuse("needs_can_fd_or_lower_rate");
      return Nrc::kConditionsNotCorrect;
    }
    parts.recording.discard();
    services.recording_scene_crc = parts.store.image_crc();
    parts.core.observers().recorder.request_counts_only(counts_only);
    return services.command.begin(call, Command::kRecord);
  });
}

}  // namespace

Nrc start_recording(Services& services, Call& call) noexcept {
  return begin_recording(services, call, false);
}

Nrc start_recording_counts(Services& services, Call& call) noexcept {
  return begin_recording(services, call, true);
}

Nrc end_recording(Services& services, Call& call) noexcept {
  return services.jobs.run(call, services.end_recording,
                           [&]() noexcept { return services.end_recording.begin(RecordingEnd::kStopped); });
}

// What it began with: RecordingStart, then a RecordingArm for each arm.
Nrc recording_start(Services& services, Call& call) noexcept {
  const RecordingStart* recording = services.parts.core.observers().recorder.start();
  const Config& config = services.parts.config;
  if (recording == nullptr) return Nrc::kRequestSequenceError;  // there was none yet
  link::RecordingStart start = recording->start;
  start.scene_crc = services.recording_scene_crc;
  call.answer.put_record(start);
  for (std::size_t i = 0; i < config.arm_count; ++i) {
    link::RecordingArm arm = recording->arms[i];
    arm.has_index = config.arm[i].has_index;
    const kinematics::BasePose& base = config.arm[i].base;
    for (int axis = 0; axis < 3; ++axis) arm.home_m[static_cast<std::size_t>(axis)] = base.home_m[axis];
    for (int k = 0; k < 9; ++k) arm.rotation[static_cast<std::size_t>(k)] = base.rotation(k / 3, k % 3);
    call.answer.put_record(arm);
  }
  return Nrc::kOk;
}

}  // namespace thimble::firmware
