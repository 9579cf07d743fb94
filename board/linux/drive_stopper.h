// Switches drives off by sockets of its own, ready to be used by a second process (guardian.h) after a fork, and after everything else has
// failed: one frame for each drive, made at start. Nothing waits longer than a few transmissions, allocates or throws.
#pragma once

#include <span>
#include <vector>

#include "board/linux/drives/can_socket.h"
#include "board/linux/drives/drive_config.h"
#include "board/posix/descriptor.h"

namespace thimble::board {

class DriveStopper {
 public:
  // `socket` sends; nothing is read from it.
  void add(Descriptor socket, std::span<const drives::DriveConfig> bus);
  // May be called again, and by a process that shares the sockets.
  void stop() noexcept;

 private:
  struct Bus {
    drives::CanSocket socket;
    std::vector<drives::CanFrame> frames;
  };
  std::vector<Bus> buses_;
};

}  // namespace thimble::board
