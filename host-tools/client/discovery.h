// Finds devices: simulators that announce themselves in the runtime directory, serial ports by name, and CAN interfaces
// that are up and may have a device on their bus. Used by `thimble list`, and by the other verbs to choose their device.
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

// Only devices of this user: simulators of others, and what others put in the place of their announcements, are not among them.
// `trouble`, if given, is told why simulators could not be looked for, as a sentence; empty: no trouble.
[[nodiscard]] std::vector<DeviceEntry> discover(std::string* trouble = nullptr);

// The URI of the device that a user asked for. wish: a URI, a name from discover(), or empty for the only device. A CAN
// interface is never the default, because nothing tells what is on its bus. Error kNotFound: none, or none of that name. kAmbiguous:
// several; the cause lists them. kPermission: none, and where simulators are announced is not this user's.
[[nodiscard]] std::string choose_device(const std::string& wish);

}  // namespace thimble::host
