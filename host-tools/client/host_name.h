// How this program calls itself to a device, for the device's audit record. Nobody checks it.
#pragma once

#include <string>

namespace thimble::host {

// "alice@lab thimble upload": the user, this machine and the program, cut to what a device keeps (link::kHostNameBytes), in printable ASCII.
// Empty: the name of the running program.
[[nodiscard]] std::string host_name(const std::string& program);
// The same of given parts: the program is cut last.
[[nodiscard]] std::string host_name(const std::string& user, const std::string& machine,
                                    const std::string& program);

}  // namespace thimble::host
