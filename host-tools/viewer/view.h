// `thimble view`: a device, or a simulated one, as a web page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/client/device.h"

namespace thimble::host {

struct ViewOptions {
  std::string device;  // address or name; empty: the only one
  DeviceOptions device_options;
  std::filesystem::path scene;                    // start a simulated device with it instead
  std::string arm = "premium-1.5";                // of the simulated one
  std::optional<kinematics::ArmData> arm_data{};  // another arm in its place
  std::uint8_t arms = 1;
  std::filesystem::path scenes;  // a folder of scenes to pick from, besides those that are found
  std::string listen;            // an address; empty: loopback
  std::uint16_t port = 0;
  std::string version;
};

// Serves until SIGINT, SIGTERM or SIGHUP. serving(url, device's address): once, when pages can come. Throws Error when it cannot begin.
void view(const ViewOptions& options,
          const std::function<void(const std::string& url, const std::string& device)>& serving);

// Opens the address with the desktop's browser, or $BROWSER; what went wrong, in a sentence; empty: nothing.
[[nodiscard]] std::string open_browser(const std::string& url);

}  // namespace thimble::host
