// Notifies a service manager (systemd) over the socket in NOTIFY_SOCKET that the board is ready, alive or
// stopping. The protocol is a text datagram (sd_notify(3)), so libsystemd is not needed. Background context.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "board/posix/descriptor.h"

namespace thimble::board {

class ServiceManager {
 public:
  // From the environment: NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID. Without a service manager tell()
  // does nothing. Throws std::system_error if NOTIFY_SOCKET is not usable.
  ServiceManager();

  void tell(std::string_view state) noexcept;  // "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1"
  // Longest permitted time between two "WATCHDOG=1"; 0: no watchdog.
  [[nodiscard]] std::uint64_t watchdog_us() const noexcept { return watchdog_us_; }

 private:
  Descriptor socket_;  // connected; closed without a service manager
  std::uint64_t watchdog_us_ = 0;
};

}  // namespace thimble::board
