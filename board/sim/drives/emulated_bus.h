// Emulated drives at one end of a socket: a raw CAN socket, or an end of a socketpair (SOCK_SEQPACKET) with struct can_frame and canfd_frame.
//
// Who calls it: thimble-sim-drive in real time, tests in their own. A frame reaches all drives at the time of run(); the bus itself takes no
// time (board/linux/drives/bus_time.h computes it).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "board/posix/descriptor.h"
#include "board/sim/drives/emulated_drive.h"

namespace thimble::board::emulated {

class EmulatedBus {
 public:
  explicit EmulatedBus(Descriptor socket) : socket_(std::move(socket)) {}

  template <class Drive>
  Drive& add(std::unique_ptr<Drive> drive) {
    Drive& added = *drive;
    drives_.push_back(std::move(drive));
    return added;
  }
  // Moves the drives on to now_us, gives them what has come, and sends what is due. now_us does not go back.
  void run(std::uint64_t now_us);

  // When the next frame is due; the largest number: none waits.
  [[nodiscard]] std::uint64_t next_due_us() const;

  // Sends as it is: an error frame of the controller, a frame of a stranger.
  void send_raw(std::span<const std::byte> bytes);
  void send(const CanFrame& frame);

  bool swap_next_two = false;                                   // the next two replies change places
  std::vector<CanFrame>* tap = nullptr;                         // every frame on the bus is added
  [[nodiscard]] std::uint64_t heard() const { return heard_; }  // frames
  [[nodiscard]] int descriptor() const { return socket_.get(); }

 private:
  Descriptor socket_;
  std::vector<std::unique_ptr<EmulatedDrive>> drives_;
  std::uint64_t heard_ = 0;
};

}  // namespace thimble::board::emulated
