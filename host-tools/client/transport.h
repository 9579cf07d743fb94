// CAN frames to and from a device, over one of these carriers. Used by ServiceClient; one thread.
//
//   slcan:/dev/ttyACM0        SLCAN on a serial port or pty
//   tcp:127.0.0.1:29536       SLCAN on TCP
//   can:can0                  SocketCAN, classic frames
//   canfd:can0                SocketCAN, FD frames too
//
// Every wait has a deadline. Errors: kUsage (not such a URI), kNotFound (nothing there), kPermission, kRefused (in use),
// kLinkLost (it disappeared; of a CAN interface also: down, bus off).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "firmware/link/can_frame.h"

namespace thimble::host {

namespace link = firmware::link;

// Microseconds of the monotonic clock that every deadline here refers to.
[[nodiscard]] link::Micros now_us();
// Another clock, for tests whose device has simulated time. Null: the monotonic one.
using MicrosClock = link::Micros (*)();
void use_clock(MicrosClock clock);

class Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;
  virtual void send(const link::CanFrame& frame) = 0;
  // The next frame, or nothing once `deadline_us` has passed.
  [[nodiscard]] virtual std::optional<link::CanFrame> receive(link::Micros deadline_us) = 0;

  [[nodiscard]] virtual bool carries_fd() const { return true; }
  // From now on, only the frames of this node need come through: its real-time frames, its grants of addresses, and its
  // answers to the host with this address.
  virtual void listen_to(std::uint8_t /*node*/, std::uint8_t /*host*/) {}
};

[[nodiscard]] std::unique_ptr<Transport> open_transport(const std::string& uri);

}  // namespace thimble::host
