#include "host-tools/client/discovery.h"

#include <filesystem>
#include <system_error>

#include "board/sim/announcement.h"
#include "host-tools/error.h"

namespace thimble::host {

std::vector<DeviceEntry> discover() {
  std::vector<DeviceEntry> found;
  for (const board::Announcement& a : board::announcements())
    found.push_back({a.name, "simulator", a.arm, a.uris});
  std::error_code none;
  for (const auto& port : std::filesystem::directory_iterator("/dev/serial/by-id", none)) {
    const std::string name = port.path().filename().string();
    if (name.find("himble") != std::string::npos)
      found.push_back({name, "serial", "", {"slcan:" + port.path().string()}});
  }
  return found;
}

std::string choose_device(const std::string& wish) {
  if (wish.find(':') != std::string::npos) return wish;
  const std::vector<DeviceEntry> devices = discover();
  if (!wish.empty()) {
    for (const DeviceEntry& device : devices) {
      if (device.name == wish) return device.uris.front();
    }
    throw Error(
        ExitCode::kNotFound, "no-device", "there is no device named '" + wish + "'",
        "`thimble list` shows what is there; an address is slcan:/dev/ttyACM0 or tcp:127.0.0.1:29536");
  }
  if (devices.empty()) {
    throw Error(ExitCode::kNotFound, "no-device", "no device was found",
                "connect a controller, or start thimble-sim; name an address with --device");
  }
  if (devices.size() > 1) {
    std::string names;
    for (const DeviceEntry& device : devices) names += (names.empty() ? "" : ", ") + device.name;
    throw Error(ExitCode::kAmbiguous, "several-devices", "there are several devices: " + names,
                "choose one with --device NAME");
  }
  return devices.front().uris.front();
}

}  // namespace thimble::host
