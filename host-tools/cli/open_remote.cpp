#include "host-tools/cli/open_remote.h"

#include <fmt/format.h>
#include <unistd.h>

#include "host-tools/cli/output.h"
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

Device open_device(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  if (common.json || isatty(STDERR_FILENO) == 0) return device;
  fmt::print(stderr, "{} {} on board {}\n", device.text(link::kDidArmName),
             device.text(link::kDidFirmwareVersion), device.text(link::kDidBoardName));
  return device;
}

std::string mode_shown(std::uint8_t mode, std::uint8_t flags) {
  constexpr unsigned kMovesItself = 1U << 5U, kHostRenders = 1U << 6U;  // of Status and DeviceState
  return mode_name(mode) + ((flags & kMovesItself) != 0 ? ",moves_by_itself" : "") +
         ((flags & kHostRenders) != 0 ? ",host_renders" : "");
}

void print_mode(const Common& common, const char* verb, std::uint8_t mode) {
  if (common.json) {
    Json json = document(verb);
    json["mode"] = mode_name(mode);
    print(json);
  } else {
    fmt::print("{}\n", mode_name(mode));
  }
}

}  // namespace thimble::host
