#include "host-tools/lab/record_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "firmware/link/services.h"
#include "host-tools/error.h"
#include "host-tools/files/image_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/device_recording.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kRound_us = 20'000;       // of DeviceRecording::tend()
constexpr Micros kGrow_us = 100'000;       // interval of writes to the file
constexpr Micros kSilence_us = 3'000'000;  // without a frame for this time the device counts as lost
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

// One run, from the recording's start to the end of its file.
class Run {
 public:
  Run(Device& device, const RecordOptions& options)
      : device_(device),
        options_(options),
        recording_(device, scene_that_runs(device, options.scene, options.output), options.tool) {}

  RecordReport go(const std::function<bool()>& stopping, const std::function<void()>& running) {
    OutputFile file(options_.output);
    recording_.claim(options_.take_over);
    device_.set_listener([this](const link::CanFrame& frame) {
      heard_us_ = now_us();
      recording_.take(frame);
    });
    std::optional<Error> failure;
    try {
      recording_.start(file.stream());
      follow(file, stopping, running);
      report_.end = recording_.finish(file.stream());
    } catch (const Error& error) {
      failure = error;
      let_go();
    }
    device_.set_listener({});
    if (failure && (!followed_ || !file.stream()))
      throw Error(*failure);  // nothing to keep, or the disk is full
    if (failure) report_.end = recording_.break_off(file.stream(), failure->name);
    file.commit();
    if (failure) throw Error(*failure);
    report_.ticks = recording_.ticks();
    report_.telemetry_ticks = recording_.telemetry_ticks();
    report_.counts_Hz = static_cast<std::uint64_t>(std::lround(recording_.rate_Hz()));
    report_.frames_per_s = static_cast<std::uint64_t>(
        std::lround(recording_.rate_Hz() * (static_cast<double>(recording_.arms()) + 1.0 / 16.0)));
    return report_;
  }

 private:
  void disarm() {
    device_.disarm();
    options_.armed(false);
  }

  // After a failure: disarms and ends the recording, if the device still answers.
  void let_go() {
    if (!recording_.begun()) return;
    try {
      if (options_.arm) disarm();
      device_.end_recording();
    } catch (const Error&) {
      return;
    }
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
    Micros grown_us = start_us;
    while (!stopping() && now_us() < end_us && recording_.tend()) {
      const Micros round_us = std::min(end_us, now_us() + kRound_us);
      while (now_us() < round_us && !recording_.ended()) static_cast<void>(device_.telemetry(round_us));
      if (now_us() - grown_us > kGrow_us) {
        grown_us = now_us();
        recording_.write(file.stream());
        file.flush();
      }
      if (now_us() - heard_us_ > kSilence_us) {
        throw Error(ExitCode::kLinkLost, "no-telemetry", "the device has been silent for 3 s",
                    "check that it still runs");
      }
    }
    if (options_.arm) disarm();
  }

  Device& device_;
  const RecordOptions& options_;
  DeviceRecording recording_;
  RecordReport report_;
  Micros heard_us_ = 0;
  bool followed_ = false;  // it runs, and the device is armed if it was to be
};

}  // namespace

RecordReport record(Device& device, const RecordOptions& options, const std::function<bool()>& stopping,
                    const std::function<void()>& running) {
  return Run(device, options).go(stopping, running);
}

}  // namespace thimble::host
