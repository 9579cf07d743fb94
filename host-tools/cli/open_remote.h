// The device that a verb is for.
#pragma once

#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"

namespace thimble::host {

[[nodiscard]] DeviceOptions options_of(const Remote& remote);
[[nodiscard]] Device open_remote(const Remote& remote);

}  // namespace thimble::host
