#include "host-tools/viewer/session_recording.h"

#include "firmware/core/faults.h"
#include "host-tools/viewer/device_session.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kWrite_us = 100'000;
constexpr Micros kTell_us = 500'000;
constexpr std::size_t kMostBytes = std::size_t{64} << 20U;  // 45 minutes of one arm at 4 kHz

Json recording_json(const DeviceRecording& recording, bool on) {
  const double seconds = static_cast<double>(recording.ticks() + recording.missing()) / recording.rate_Hz();
  return {{"type", "recording"},
          {"on", on},
          {"seconds", seconds},
          {"ticks", recording.ticks()},
          {"missing", recording.missing()}};
}

}  // namespace

void DeviceSession::listen(Micros until_us) {
  static_cast<void>(device_->telemetry(until_us));
  tend_recording();
}

void DeviceSession::obey(const RecordMessage& message) {
  if (message.on && !recording_) {
    begin_recording();
  } else if (!message.on && recording_) {
    finish_recording();
  }
}

void DeviceSession::begin_recording() {
  const link::DeviceState state = device_->state();
  if (!running_ || crc32(*running_->image) != state.scene_crc) {
    throw Error(ExitCode::kRefused, "no-scene-file",
                "a recording contains its scene, and the one that runs is not known here",
                "load a scene, then record");
  }
  if (state.mode == link::Mode::kArmed || state.mode == link::Mode::kDamping) {
    throw Error(ExitCode::kRefused, "motors-on", "a recording begins with the motors off",
                "disarm, then record; homing and arming are part of the recording");
  }
  recording_ = std::make_unique<SessionRecording>(*device_, *running_->image, options_.version);
  if (const std::optional<Error> failure = start_recording()) {
    if (recording_->device.begun()) abandon_recording();
    recording_.reset();
    throw Error(*failure);
  }
  recording_->runs = true;
}

std::optional<Error> DeviceSession::start_recording() {
  try {
    recording_->device.claim(false);
    recording_->device.start(recording_->file);
    return std::nullopt;
  } catch (const Error& error) {
    return error;
  }
}

void DeviceSession::abandon_recording() {
  try {
    device_->end_recording();
  } catch (const Error&) {
    return;  // it ends by itself, as nobody keeps it alive
  }
}

void DeviceSession::tend_recording() {
  if (!recording_ || !recording_->runs) return;
  const Micros now = now_us();
  if (now >= recording_->write_due_us) {
    recording_->write_due_us = now + kWrite_us;
    recording_->device.write(recording_->file);
  }
  if (now >= recording_->tell_due_us) {
    recording_->tell_due_us = now + kTell_us;
    sink_.event(recording_json(recording_->device, true));
  }
  const bool full = static_cast<std::size_t>(recording_->file.tellp()) > kMostBytes;
  if (full)
    inform("recording-full", "the recording is as large as a page may make it", "use `thimble record`");
  if (full || !recording_->device.tend()) finish_recording();
}

void DeviceSession::finish_recording() {
  try {
    recording_->runs = false;
    hand_over(recording_->device.finish(recording_->file));
  } catch (const Error& error) {
    if (error.code == ExitCode::kLinkLost) throw;  // serve_until_lost() breaks it off
    sink_.event(event_json(error));
    break_off_recording(error.name);
  }
}

// What has come is whole up to there.
void DeviceSession::break_off_recording(const std::string& reason) {
  if (!recording_) return;
  if (recording_->device.begun()) hand_over(recording_->device.break_off(recording_->file, reason));
  recording_.reset();
}

void DeviceSession::hand_over(const RecordingEnd& end) {
  Json json = recording_json(recording_->device, false);
  json["missing"] = end.missing;
  json["dropped"] = end.dropped;
  json["end"] = end.reason;
  const firmware::FaultRow* fault = firmware::find_fault(static_cast<firmware::Fault>(end.fault));
  if (end.fault != 0 && fault != nullptr) json["fault"] = fault->name;
  auto bytes = std::make_shared<const std::string>(std::move(recording_->file).str());
  json["bytes"] = bytes->size();
  recording_.reset();
  sink_.recording(json, std::move(bytes));
}

}  // namespace thimble::host
