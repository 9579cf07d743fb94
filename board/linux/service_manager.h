// What a service manager (systemd) is told over the socket in NOTIFY_SOCKET: that the board is ready, lives, ends. The protocol
// is a datagram of text (sd_notify(3)); libsystemd would be a dependency for twenty lines. Background context.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "board/posix/descriptor.h"

namespace thimble::board {

class ServiceManager {
 public:
  // From the environment: NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID. Without a service manager tell() does nothing.
  // Throws std::system_error where NOTIFY_SOCKET names none that can be.
  ServiceManager();

  void tell(std::string_view state) noexcept;  // "READY=1", "STATUS=...", "WATCHDOG=1", "STOPPING=1"
  // At most this long between two "WATCHDOG=1"; 0: it does not watch.
  [[nodiscard]] std::uint64_t watchdog_us() const noexcept { return watchdog_us_; }

 private:
  Descriptor socket_;  // connected; none: no service manager
  std::uint64_t watchdog_us_ = 0;
};

}  // namespace thimble::board
