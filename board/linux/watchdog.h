// A kernel watchdog: once opened, it restarts the machine unless it is fed. Background context.
#pragma once

#include <filesystem>

#include "board/posix/descriptor.h"

namespace thimble::board {

class Watchdog {
 public:
  // Starts the watchdog. Throws std::system_error with the device, also if the file is not a watchdog.
  Watchdog(const std::filesystem::path& device, int timeout_s);
  explicit Watchdog(Descriptor device) noexcept;  // an already running watchdog

  // The machine's last restart was by this watchdog; false also if the driver cannot tell.
  [[nodiscard]] bool restarted_machine() const noexcept;
  // False: feeding failed; the watchdog will expire.
  [[nodiscard]] bool feed() noexcept;
  // Orderly end: the next close stops the watchdog (the kernel's "magic close"; not with the driver option
  // nowayout). Without this call the watchdog keeps running after the program has ended.
  [[nodiscard]] bool disarm() noexcept;

 private:
  Descriptor device_;
};

}  // namespace thimble::board
