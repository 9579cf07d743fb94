#include "host-tools/lab/record_run.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>
#include <sstream>

#include "firmware/core/faults.h"
#include "firmware/link/services.h"
#include "firmware/params.h"
#include "host-tools/error.h"
#include "host-tools/files/image_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/recorder.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kRound_us = 20'000;        // interval of keep-alives: link_timeout is at least 50 ms
constexpr Micros kGrow_us = 100'000;        // interval of writes to the file
constexpr Micros kAsk_us = 1'000'000;       // how the recording is, besides what it says on its way
constexpr Micros kSilence_us = 3'000'000;   // without a frame for this time the device counts as lost
constexpr Micros kLastFrames_us = 500'000;  // after the recording was ended
constexpr Micros kHoming_us = 30'000'000;

std::vector<std::byte> scene_that_runs(Device& device, const std::filesystem::path& file,
                                       const std::filesystem::path& output) {
  const link::DeviceState state = device.state();
  if (state.scene_bytes == 0) {
    throw Error(ExitCode::kRefused, "no-scene", "the device has no scene",
                "send one first (`thimble upload`)");
  }
  ImageFile loaded = load_image(file);
  keep_apart(loaded.files, output);
  std::vector<std::byte>& image = loaded.image;
  const std::uint32_t crc = crc32(image);
  if (crc != state.scene_crc) {
    char text[160];
    std::snprintf(text, sizeof text, "%s makes an image with the CRC-32 %08x; the device runs '%s' with %08x",
                  file.filename().string().c_str(), crc, device.text(link::kDidSceneName).c_str(),
                  state.scene_crc);
    throw Error(ExitCode::kVerification, "other-scene", text,
                "name the scene file that was uploaded with --scene, or upload it again");
  }
  return std::move(image);
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

// One run, from the recording's start to the end of its file.
class Run {
 public:
  Run(Device& device, const RecordOptions& options)
      : device_(device), options_(options), recorder_(device.info().node, device.info().arms) {}

  RecordReport go(const std::function<bool()>& stopping, const std::function<void()>& running) {
    header_.scene = scene_that_runs(device_, options_.scene, options_.output);
    describe();
    OutputFile file(options_.output);
    claim();
    begun_us_ = now_us();
    device_.set_listener([this](const link::CanFrame& frame) {
      heard_us_ = now_us();
      recorder_.take(frame, static_cast<std::uint32_t>(heard_us_ - begun_us_));
    });
    device_.start_recording();
    std::optional<Error> failure;
    try {
      open(file);
      follow(file, stopping, running);
      finish();
    } catch (const Error& error) {
      report_.end.reason = error.name;
      failure = error;
      let_go();
    }
    device_.set_listener({});
    if (failure && (!followed_ || !file.stream()))
      throw Error(*failure);  // nothing to keep, or the disk is full
    if (report_.end.ticks > recorder_.ticks()) {
      report_.end.missing = static_cast<std::uint32_t>(report_.end.ticks - recorder_.ticks());
    } else {
      report_.end.missing = static_cast<std::uint32_t>(recorder_.missing());
    }
    recorder_.write(file.stream());
    write_end(file.stream(), report_.end);
    file.commit();
    if (failure) throw Error(*failure);
    report_.ticks = recorder_.ticks();
    return report_;
  }

 private:
  void describe() {
    header_.tool = options_.tool;
    header_.firmware = device_.text(link::kDidFirmwareVersion);
    header_.board = device_.text(link::kDidBoardName);
    header_.serial = device_.text(link::kDidSerialNumber);
    header_.models = split(device_.text(link::kDidArmName));
    header_.scene_name = device_.text(link::kDidSceneName);
    header_.node = device_.info().node;
    header_.began = std::time(nullptr);
  }

  // The recording is this program's.
  void claim() {
    const bool runs = device_.recording_state().phase == link::RecordingPhase::kRunning;
    if (runs && !options_.take_over) {
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
  }

  void open(OutputFile& file) {
    std::tie(header_.start, header_.arms) = device_.recording_start();
    read_parameters();
    if (header_.start.scene_crc != crc32(header_.scene)) {
      throw Error(ExitCode::kVerification, "other-scene", "the device's scene has changed meanwhile",
                  "repeat the command");
    }
    header_.scene_crc = header_.start.scene_crc;
    recorder_.begin(header_.start);
    write_header(file.stream(), header_);
  }

  void disarm() {
    device_.disarm();
    options_.armed(false);
  }

  // After a failure: disarms and ends the recording, if the device still answers.
  void let_go() {
    try {
      if (options_.arm) disarm();
      device_.end_recording();
    } catch (const Error&) {
      return;
    }
  }

  // Writing a parameter would have ended the recording, so these values hold for all of it.
  void read_parameters() {
    for (const firmware::ParamRow& row : firmware::kParamTable)
      header_.parameters.emplace_back(row.id, device_.param_bits(row));
    report_.telemetry_ticks = device_.param_bits(row_of(firmware::Param::telemetry_decimation));
    const link::RecordingState state = device_.recording_state();
    if (state.end == link::RecordingEnd::kParameter) {
      throw Error(ExitCode::kRefused, "parameter-written",
                  "somebody wrote a parameter while the recording began", "repeat the command");
    }
    const double rate_Hz = 1.0 / static_cast<double>(header_.start.period_s);
    report_.counts_Hz = static_cast<std::uint64_t>(std::lround(rate_Hz));
    report_.frames_per_s =
        static_cast<std::uint64_t>(std::lround(rate_Hz * (header_.start.arms + 1.0 / 16.0)));
  }

  void follow(OutputFile& file, const std::function<bool()>& stopping, const std::function<void()>& running) {
    if (options_.home) device_.home(kHoming_us, stopping);
    if (options_.arm && !stopping()) {
      options_.armed(true);
      device_.arm();
    }
    if (!stopping()) running();
    followed_ = true;
    file.keep_draft();
    const Micros start_us = now_us();
    const Micros end_us =
        options_.seconds > 0 ? start_us + static_cast<Micros>(options_.seconds * 1e6) : ~Micros{0};
    heard_us_ = start_us;
    Micros asked_us = start_us;
    Micros grown_us = start_us;
    while (!stopping() && !recorder_.ended() && now_us() < end_us) {
      const Micros round_us = std::min(end_us, now_us() + kRound_us);
      while (now_us() < round_us && !recorder_.ended()) static_cast<void>(device_.telemetry(round_us));
      device_.keep_alive();
      if (now_us() - grown_us > kGrow_us) {
        grown_us = now_us();
        recorder_.write(file.stream());
        file.flush();
      }
      if (now_us() - heard_us_ > kSilence_us) {
        throw Error(ExitCode::kLinkLost, "no-telemetry", "the device has been silent for 3 s",
                    "check that it still runs");
      }
      if (now_us() - asked_us > kAsk_us) {
        asked_us = now_us();
        if (device_.recording_state().phase != link::RecordingPhase::kRunning) break;
      }
    }
    if (options_.arm) disarm();
  }

  void finish() {
    if (!recorder_.ended()) device_.end_recording();
    const Micros last_us = now_us() + kLastFrames_us;
    while (!recorder_.ended() && now_us() < last_us) static_cast<void>(device_.telemetry(last_us));
    const link::RecordingState state = device_.recording_state();
    if (state.phase == link::RecordingPhase::kRunning) {  // of another program
      report_.end.reason = "taken_over";
      report_.end.ticks = static_cast<std::uint32_t>(recorder_.ticks() + recorder_.missing());
      return;
    }
    report_.end.reason = link::name(state.end);
    report_.end.ticks = state.ticks;
    report_.end.dropped = state.dropped;
    if (state.end == link::RecordingEnd::kFault) report_.end.fault = device_.state().fault;
  }

  Device& device_;
  const RecordOptions& options_;
  Recorder recorder_;
  RecordingHeader header_;
  RecordReport report_;
  Micros begun_us_ = 0;
  Micros heard_us_ = 0;
  bool followed_ = false;  // it runs, and the device is armed if it was to be
};

}  // namespace

RecordReport record(Device& device, const RecordOptions& options, const std::function<bool()>& stopping,
                    const std::function<void()>& running) {
  return Run(device, options).go(stopping, running);
}

}  // namespace thimble::host
