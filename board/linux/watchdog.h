// A watchdog of the kernel: once open the machine restarts unless it is fed. Background context.
#pragma once

#include <filesystem>

#include "board/posix/descriptor.h"

namespace thimble::board {

class Watchdog {
 public:
  // Starts it. Throws std::system_error with the device, also for a file that is no watchdog.
  Watchdog(const std::filesystem::path& device, int timeout_s);
  explicit Watchdog(Descriptor device) noexcept;  // one that runs

  // False: it was not reached, and will bite.
  [[nodiscard]] bool feed() noexcept;
  // The orderly end: the next close stops it (the kernel's "magic close"; not where its driver was told nowayout). Without
  // this call a program that ends leaves it running.
  [[nodiscard]] bool disarm() noexcept;

 private:
  Descriptor device_;
};

}  // namespace thimble::board
