#include "host-tools/cli/open_remote.h"

#include <fmt/format.h>
#include <unistd.h>

#include "host-tools/cli/output.h"
#include "host-tools/client/discovery.h"
#include "host-tools/client/key_file.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

DeviceOptions options_of(const Remote& remote) {
  DeviceOptions options;
  options.node = static_cast<std::uint8_t>(remote.node);
  options.answer_us = static_cast<link::Micros>(remote.timeout_s * 1e6) / options.tries;
  options.prove = prove_with(remote.key);
  options.program = remote.program;
  return options;
}

Device open_remote(const Remote& remote) {
  return Device(open_transport(choose_device(remote.device)), options_of(remote));
}

Device open_device(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  if (common.json || isatty(STDERR_FILENO) == 0) return device;
  say(stderr, "{} {} on board {}\n", device.text(link::kDidArmName), device.text(link::kDidFirmwareVersion),
      device.text(link::kDidBoardName));
  return device;
}

std::string mode_shown(link::Mode mode, const link::StatusFlags& flags) {
  return std::string(name(mode)) + (flags.moves_itself ? ",moves_by_itself" : "") +
         (flags.host_renders ? ",host_renders" : "");
}

void print_mode(const Common& common, const char* verb, link::Mode mode) {
  if (common.json) {
    Json json = document(verb);
    json["mode"] = name(mode);
    print(json);
  } else {
    say("{}\n", name(mode));
  }
}

}  // namespace thimble::host
