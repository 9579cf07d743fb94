// A device recorded into a file: what `thimble record` does. Failures are Errors; one that comes once the recording runs leaves a file that
// is whole up to there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host-tools/client/device.h"
#include "host-tools/lab/recording.h"

namespace thimble::host {

struct RecordOptions {
  std::filesystem::path output;
  std::filesystem::path scene;  // the file that the device's scene was made from
  double seconds = 0;           // 0: until stopping() says so, or the recording ends
  bool home = false;            // first of all, in the recording
  bool arm = false;             // and disarm at the end
  std::function<void(bool)> armed = [](bool) {
  };  // told true before it arms, which it may refuse by an Error; false once it is disarmed
  bool take_over = false;  // end the recording that another program may have begun
  std::string tool;        // version of this program
};

struct RecordReport {
  RecordingEnd end;
  std::uint64_t ticks = 0;
  std::uint64_t counts_Hz = 0;        // of the loop: every tick is recorded
  std::uint32_t telemetry_ticks = 0;  // between two of the other telemetry's records: telemetry_decimation
  std::uint64_t frames_per_s = 0;     // that the recording takes
};

// `running` is called once the recording runs (and the device is armed, if it was to be).
RecordReport record(Device& device, const RecordOptions& options, const std::function<bool()>& stopping,
                    const std::function<void()>& running);

}  // namespace thimble::host
