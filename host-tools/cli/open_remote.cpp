#include "host-tools/cli/open_remote.h"

#include "host-tools/client/discovery.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

DeviceOptions options_of(const Remote& remote) {
  DeviceOptions options;
  options.node = static_cast<std::uint8_t>(remote.node);
  options.answer_us = static_cast<link::Micros>(remote.timeout_s * 1e6) / options.tries;
  return options;
}

Device open_remote(const Remote& remote) {
  return Device(open_transport(choose_device(remote.device)), options_of(remote));
}

}  // namespace thimble::host
