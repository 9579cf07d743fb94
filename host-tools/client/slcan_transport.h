// SLCAN on a serial port, pty or TCP. Called by open_transport(); `uri` stands in errors.
#pragma once

#include <memory>
#include <string>

#include "host-tools/client/transport.h"

namespace thimble::host {

[[nodiscard]] std::unique_ptr<Transport> open_serial(const std::string& path, const std::string& uri);
[[nodiscard]] std::unique_ptr<Transport> open_tcp(const std::string& host, const std::string& port,
                                                  const std::string& uri);

}  // namespace thimble::host
