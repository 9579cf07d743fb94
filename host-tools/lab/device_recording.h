// One recording of a device (docs/recording.md), by a program that goes on with its own work meanwhile. Who calls it: `thimble record`
// (record_run.h) and the session of a viewer; one thread.
//
//   DeviceRecording recording(device, image, version);
//   recording.claim(false);
//   device.set_listener([&](const link::CanFrame& frame) { recording.take(frame); });
//   recording.start(out);
//   while (recording.tend()) { device.telemetry(...); recording.write(out); }   // sooner or later; at least each 20 ms
//   recording.finish(out);
//
// Besides those that are named here, functions throw what Device throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "host-tools/client/device.h"
#include "host-tools/lab/recorder.h"
#include "host-tools/lab/recording.h"

namespace thimble::host {

class DeviceRecording {
 public:
  // scene: the image that the device runs. tool: version of the program.
  DeviceRecording(Device& device, std::vector<std::byte> scene, std::string tool);

  // The recording is to be this program's. take_over: it ends that of another one. Error kRefused: `recording-runs`, `motors-on`.
  void claim(bool take_over);
  // Every real-time frame since claim().
  void take(const link::CanFrame& frame);
  // Begins, and writes the header. Error kVerification `other-scene`, kRefused `parameter-written`.
  void start(std::ostream& out);
  [[nodiscard]] bool begun() const { return begun_; }  // the device records, also if start() failed then
  // Gives the device a sign of life when it is due. False: the recording has ended.
  [[nodiscard]] bool tend();
  // What came since the last call.
  void write(std::ostream& out) { recorder_.write(out); }
  // Ends it, unless the device has, and writes what is left and the end.
  RecordingEnd finish(std::ostream& out);
  // The same without the device, which is lost. reason: the name of the error.
  RecordingEnd break_off(std::ostream& out, const std::string& reason);

  [[nodiscard]] bool ended() const { return recorder_.ended(); }  // the device said so on the way
  [[nodiscard]] std::uint64_t ticks() const { return recorder_.ticks(); }
  [[nodiscard]] std::uint64_t missing() const { return recorder_.missing(); }
  // Once start() has returned.
  [[nodiscard]] double rate_Hz() const { return 1.0 / static_cast<double>(header_.start.period_s); }
  [[nodiscard]] std::size_t arms() const { return header_.start.arms; }
  [[nodiscard]] std::uint32_t telemetry_ticks() const { return telemetry_ticks_; }

 private:
  void describe();
  void read_parameters();
  void close(std::ostream& out, RecordingEnd& end);

  Device& device_;
  Recorder recorder_;
  RecordingHeader header_;
  std::uint32_t telemetry_ticks_ = 0;
  bool begun_ = false;
  link::Micros begun_us_ = 0;
  link::Micros alive_due_us_ = 0;
  link::Micros ask_due_us_ = 0;
};

}  // namespace thimble::host
