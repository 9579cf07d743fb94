#include "host-tools/lab/device_recording.h"

#include <ctime>
#include <sstream>
#include <tuple>
#include <utility>

#include "firmware/link/services.h"
#include "firmware/params.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kAlive_us = 20'000;        // interval of signs of life: link_timeout is at least 50 ms
constexpr Micros kAsk_us = 1'000'000;       // how the recording is, besides what it says on its way
constexpr Micros kLastFrames_us = 500'000;  // after the recording was ended

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

DeviceRecording::DeviceRecording(Device& device, std::vector<std::byte> scene, std::string tool)
    : device_(device), recorder_(device.info().node, device.info().arms) {
  header_.scene = std::move(scene);
  header_.tool = std::move(tool);
}

void DeviceRecording::describe() {
  header_.firmware = device_.text(link::kDidFirmwareVersion);
  header_.board = device_.text(link::kDidBoardName);
  header_.serial = device_.text(link::kDidSerialNumber);
  header_.models = split(device_.text(link::kDidArmName));
  header_.scene_name = device_.text(link::kDidSceneName);
  header_.node = device_.info().node;
  header_.began = std::time(nullptr);
}

void DeviceRecording::claim(bool take_over) {
  describe();
  const bool runs = device_.recording_state().phase == link::RecordingPhase::kRunning;
  if (runs && !take_over) {
    throw Error(ExitCode::kRefused, "recording-runs", "another program is recording this device",
                "wait until it has ended, or end its recording with --force");
  }
  const link::Mode mode = device_.state().mode;
  if (mode == link::Mode::kArmed || mode == link::Mode::kDamping) {
    throw Error(ExitCode::kRefused, "motors-on", "a recording begins with the motors off",
                "disarm first (`thimble disarm`)");
  }
  // Frames that come while another program commands must not count as this recording's: their ticks have few bits.
  device_.take_command();
  if (runs) device_.end_recording();
  begun_us_ = now_us();
}

void DeviceRecording::take(const link::CanFrame& frame) {
  recorder_.take(frame, static_cast<std::uint32_t>(now_us() - begun_us_));
}

void DeviceRecording::start(std::ostream& out) {
  device_.start_recording();
  begun_ = true;
  ask_due_us_ = now_us() + kAsk_us;
  std::tie(header_.start, header_.arms) = device_.recording_start();
  read_parameters();
  if (header_.start.scene_crc != crc32(header_.scene)) {
    throw Error(ExitCode::kVerification, "other-scene", "the device's scene has changed meanwhile",
                "repeat the command");
  }
  header_.scene_crc = header_.start.scene_crc;
  recorder_.begin(header_.start);
  write_header(out, header_);
}

// Writing a parameter would have ended the recording, so these values hold for all of it; but for those whose writes are marks
// (Recording::first_trial()).
void DeviceRecording::read_parameters() {
  for (const firmware::ParamRow& row : firmware::kParamTable)
    header_.parameters.emplace_back(row.id, device_.param_bits(row));
  telemetry_ticks_ = device_.param_bits(row_of(firmware::Param::telemetry_decimation));
  if (device_.recording_state().end == link::RecordingEnd::kParameter) {
    throw Error(ExitCode::kRefused, "parameter-written",
                "somebody wrote a parameter while the recording began", "repeat the command");
  }
}

bool DeviceRecording::tend() {
  if (recorder_.ended()) return false;
  const Micros now = now_us();
  if (now >= alive_due_us_) {
    alive_due_us_ = now + kAlive_us;
    device_.keep_alive();
  }
  if (now < ask_due_us_) return true;
  ask_due_us_ = now + kAsk_us;
  return device_.recording_state().phase == link::RecordingPhase::kRunning;
}

RecordingEnd DeviceRecording::finish(std::ostream& out) {
  if (!recorder_.ended()) device_.end_recording();
  const Micros last_us = now_us() + kLastFrames_us;
  while (!recorder_.ended() && now_us() < last_us) static_cast<void>(device_.telemetry(last_us));
  const link::RecordingState state = device_.recording_state();
  RecordingEnd end;
  if (state.phase == link::RecordingPhase::kRunning) {  // of another program
    end.reason = "taken_over";
    end.ticks = static_cast<std::uint32_t>(recorder_.ticks() + recorder_.missing());
  } else {
    end.reason = link::name(state.end);
    end.ticks = state.ticks;
    end.dropped = state.dropped;
    end.marks_missing = state.marks - recorder_.marks();
    if (state.end == link::RecordingEnd::kFault) end.fault = device_.state().fault;
  }
  close(out, end);
  return end;
}

RecordingEnd DeviceRecording::break_off(std::ostream& out, const std::string& reason) {
  RecordingEnd end;
  end.reason = reason;
  close(out, end);
  return end;
}

void DeviceRecording::close(std::ostream& out, RecordingEnd& end) {
  end.missing = static_cast<std::uint32_t>(end.ticks > recorder_.ticks() ? end.ticks - recorder_.ticks()
                                                                         : recorder_.missing());
  recorder_.write(out);
  write_end(out, end);
}

}  // namespace thimble::host
