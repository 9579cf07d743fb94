// Opens the device that a verb acts on; messages that several verbs print about it.
#pragma once

#include <cstdint>
#include <string>

#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"

namespace thimble::host {

[[nodiscard]] DeviceOptions options_of(const Remote& remote);
[[nodiscard]] Device open_remote(const Remote& remote);
// The same; on a terminal it prints arm, firmware and board on stderr. Without a terminal or with --json stderr has progress
// and errors only.
[[nodiscard]] Device open_device(const Common& common, const Remote& remote);

// "armed,host_renders": the mode and the flags (of Status and DeviceState) that a user has to know of.
[[nodiscard]] std::string mode_shown(link::Mode mode, const link::StatusFlags& flags);
// The output of a verb that has changed the mode.
void print_mode(const Common& common, const char* verb, link::Mode mode);

}  // namespace thimble::host
