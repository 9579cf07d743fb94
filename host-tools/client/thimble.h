// The public API for programs: a device by its address or name.
//
//   #include "host-tools/client/thimble.h"          // and link thimble_client
//
//   thimble::Device device = thimble::connect();    // the only one; or "tcp:127.0.0.1:29536", "can:can0", a name
//   device.home();
//
// host-tools/client/device.h is the reference: frames, units and errors of every function. docs/examples/host_wall.cpp is a whole
// program. A device belongs to one thread. Failures are thimble::Error (host-tools/error.h).
#pragma once

#include <string>

#include "host-tools/client/device.h"
#include "host-tools/client/discovery.h"
#include "host-tools/client/transport.h"
#include "host-tools/error.h"

namespace thimble {

using host::Device;
using host::Error;
using host::now_us;
using host::TipReading;

// Opens the device with this address ("tcp:127.0.0.1:29536", "can:can0", "slcan:/dev/ttyACM0") or name; without one the only
// device. Errors: kUsage, kNotFound, kAmbiguous, kPermission, kRefused (in use), kLinkLost (no answer), kVersion.
[[nodiscard]] inline Device connect(const std::string& device = {}) {
  return Device(host::open_transport(host::choose_device(device)));
}

}  // namespace thimble
