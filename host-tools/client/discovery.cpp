#include "host-tools/client/discovery.h"

#include <linux/can.h>
#include <net/if.h>
#include <net/if_arp.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "board/sim/announcement.h"
#include "host-tools/error.h"

namespace thimble::host {

namespace {

constexpr const char* kCan = "can";

// The number in a file of /sys/class/net, with or without 0x; 0 when there is none.
unsigned long number_in(const std::filesystem::path& file) {
  std::string text;
  std::ifstream(file) >> text;
  return std::strtoul(text.c_str(), nullptr, 0);
}

std::vector<DeviceEntry> can_interfaces_up() {
  std::vector<DeviceEntry> found;
  std::error_code none;
  for (const auto& interface : std::filesystem::directory_iterator("/sys/class/net", none)) {
    const std::filesystem::path& folder = interface.path();
    if (number_in(folder / "type") != ARPHRD_CAN || (number_in(folder / "flags") & IFF_UP) == 0) continue;
    const std::string name = folder.filename().string();
    DeviceEntry entry{name, kCan, "", {"can:" + name}};
    if (number_in(folder / "mtu") == CANFD_MTU) entry.uris.insert(entry.uris.begin(), "canfd:" + name);
    found.push_back(std::move(entry));
  }
  std::ranges::sort(found, {}, &DeviceEntry::name);
  return found;
}

}  // namespace

std::vector<DeviceEntry> discover(std::string* trouble) {
  std::vector<DeviceEntry> found;
  board::Announcements simulators = board::announcements();
  for (const board::Announcement& a : simulators.found) found.push_back({a.name, "simulator", a.arm, a.uris});
  if (trouble != nullptr) *trouble = std::move(simulators.trouble);
  std::error_code none;
  for (const auto& port : std::filesystem::directory_iterator("/dev/serial/by-id", none)) {
    const std::string name = port.path().filename().string();
    if (name.find("himble") != std::string::npos)
      found.push_back({name, "serial", "", {"slcan:" + port.path().string()}});
  }
  for (DeviceEntry& interface : can_interfaces_up()) found.push_back(std::move(interface));
  return found;
}

std::string choose_device(const std::string& wish) {
  if (wish.find(':') != std::string::npos) return wish;
  std::string trouble;
  std::vector<DeviceEntry> devices = discover(&trouble);
  const auto check_trouble = [&trouble] {
    if (!trouble.empty())
      throw Error(ExitCode::kPermission, "runtime-folder", "simulators cannot be looked for: " + trouble,
                  "do that, or name the device by its address: --device tcp:127.0.0.1:29536");
  };
  if (!wish.empty()) {
    for (const DeviceEntry& device : devices) {
      if (device.name == wish) return device.uris.front();
    }
    check_trouble();
    throw Error(ExitCode::kNotFound, "no-device", "there is no device named '" + wish + "'",
                "`thimble list` shows what is there; an address is slcan:/dev/ttyACM0, can:can0 or "
                "tcp:127.0.0.1:29536");
  }
  std::erase_if(devices, [](const DeviceEntry& device) { return device.kind == kCan; });
  if (devices.empty()) {
    check_trouble();
    throw Error(ExitCode::kNotFound, "no-device", "no device was found",
                "connect a controller, or start thimble-sim; what is on a CAN bus is not asked unless named: "
                "--device can:can0");
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
