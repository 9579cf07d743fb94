// For programs of your own: a device by its address or name, and no more to know.
//
//   #include "host-tools/client/thimble.h"          // and link thimble_client
//
//   thimble::Device device = thimble::connect();    // the only one; or "tcp:127.0.0.1:29536", "can:can0", a name
//   device.home();
//
// host-tools/client/device.h is the reference; docs/examples/host_wall.cpp a whole program. One thread a device. What fails
// throws thimble::Error.
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

[[nodiscard]] inline Device connect(const std::string& device = {}) {
  return Device(host::open_transport(host::choose_device(device)));
}

}  // namespace thimble
