// Gives a device another arm: its image is stored, and the device starts anew with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "host-tools/client/device.h"

namespace thimble::host {

struct ArmUpload {
  UploadResult upload;
  std::string arms;  // of the device, as it names them after its restart
};

// The connection ends; open() makes the next one. arm: its number. name: of the new arm, for the error. Errors: those of Device::upload(), and
// kVerification, "verification-failed": the device does not come back with it.
ArmUpload replace_arm(const std::function<Device()>& open, Device device, std::uint8_t arm,
                      const std::string& name, std::span<const std::byte> image);

}  // namespace thimble::host
