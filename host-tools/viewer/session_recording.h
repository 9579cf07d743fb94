// The recording that a page has asked for, in memory. Used by device_session.h only.
#pragma once

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/lab/device_recording.h"

namespace thimble::host {

struct SessionRecording {
  SessionRecording(Device& of, std::vector<std::byte> scene, std::string tool)
      : device(of, std::move(scene), std::move(tool)) {}

  DeviceRecording device;
  std::ostringstream file;
  bool runs = false;  // it is begun, and the pages know
  link::Micros write_due_us = 0;
  link::Micros tell_due_us = 0;
};

}  // namespace thimble::host
