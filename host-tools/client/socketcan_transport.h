// A SocketCAN interface as a link, classic frames or FD too. Called by open_transport().
#pragma once

#include <memory>
#include <string>

#include "host-tools/client/transport.h"

namespace thimble::host {

[[nodiscard]] std::unique_ptr<Transport> open_socketcan(const std::string& interface, bool fd);

}  // namespace thimble::host
