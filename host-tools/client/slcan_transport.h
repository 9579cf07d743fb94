// SLCAN on a serial port, pty, TCP or an open socket. `uri` stands in errors. The first two are called by open_transport().
#pragma once

#include <memory>
#include <string>

#include "host-tools/client/descriptor.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

[[nodiscard]] std::unique_ptr<Transport> open_serial(const std::string& path, const std::string& uri);
[[nodiscard]] std::unique_ptr<Transport> open_tcp(const std::string& host, const std::string& port,
                                                  const std::string& uri);
// `socket` is connected and non-blocking.
[[nodiscard]] std::unique_ptr<Transport> open_socket(Descriptor socket, const std::string& uri);

}  // namespace thimble::host
