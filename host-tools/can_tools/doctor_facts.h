// The facts about this machine that `thimble doctor` judges (doctor_findings.h). Reading them changes nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "board/posix/can_interfaces.h"

namespace thimble::host {

using board::BusState;
using board::CanController;
using board::CanInterface;

enum class DeviceKind { kSerial, kGpio, kSpi, kCounter };

struct DeviceFile {
  DeviceKind kind = DeviceKind::kSerial;
  std::string path;
  bool exists = true;
  bool usable = false;         // this process may read and write it
  std::string group;           // its group, where members may; else empty
  bool member_by_now = false;  // the user is in that group, but was not when this session began
};

struct Privileges {
  std::optional<std::uint64_t> locked_bytes;  // memory that may be locked; nothing: no limit
  std::uint64_t priority = 0;                 // of SCHED_FIFO, the highest
};

struct Facts {
  bool can_sockets = false;  // the kernel has SocketCAN
  std::vector<CanInterface> interfaces;
  std::vector<DeviceFile> devices;
  Privileges privileges;
};

// Throws Error where the kernel does not answer.
[[nodiscard]] std::vector<CanInterface> read_can_interfaces();
// A port, or any other device file.
[[nodiscard]] DeviceFile read_device(DeviceKind kind, const std::string& path);
// Every serial port that may be a controller's; of a board also GPIO, SPI and counters.
[[nodiscard]] std::vector<DeviceFile> read_devices(bool board);
[[nodiscard]] Privileges read_privileges();
[[nodiscard]] bool kernel_has_can_sockets();

}  // namespace thimble::host
