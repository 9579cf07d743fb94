// Which devices are there: simulators that announce themselves in the runtime directory, serial ports by
// name, and CAN interfaces that are up, behind which there may be one. Used by `thimble list` and to choose the one device of every other verb.
#pragma once

#include <string>
#include <vector>

namespace thimble::host {

struct DeviceEntry {
  std::string name;
  std::string kind;               // "simulator", "serial" or "can"
  std::string arm;                // of a simulator
  std::vector<std::string> uris;  // the best first
};

[[nodiscard]] std::vector<DeviceEntry> discover();

// The URI for what a user asked for: a URI as it is, a name of the list, or, with an empty wish, the only
// device there; of a CAN interface nobody knows what is on its bus, so it must be asked for. Error kNotFound: none, or none of that name. kAmbiguous: several; the cause lists them.
[[nodiscard]] std::string choose_device(const std::string& wish);

}  // namespace thimble::host
