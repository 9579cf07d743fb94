// A raw CAN socket for the drives of one interface. At start only. The system sets bit rates, sample points and queue length (docs/drives.md).
#pragma once

#include <linux/can.h>

#include <span>
#include <string>

#include "board/posix/descriptor.h"

namespace thimble::board::drives {

struct OpenedBus {
  Descriptor socket;  // not open: `trouble` says why
  std::string trouble;
};
// Receives what passes `filters` (none: everything), bus-off reports and no frames of its own; FD frames where `fd`, which an interface
// without FD refuses.
[[nodiscard]] OpenedBus open_can_bus(const std::string& interface, std::span<const can_filter> filters,
                                     bool fd);

}  // namespace thimble::board::drives
