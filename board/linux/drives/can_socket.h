// The frames of a tick through one socket: all sent by one system call, all that came read by one (up to kMostFrames). Never waits.
//
// The socket is a raw CAN socket (open_can_bus.h) or, in tests, an end of a socketpair (SOCK_SEQPACKET) that carries struct can_frame and
// struct canfd_frame. Receive stamps are the kernel's where it gives them (SO_TIMESTAMPNS), else the time of the read. No heap, no exceptions.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "board/linux/drives/drive.h"
#include "board/posix/descriptor.h"

namespace thimble::board::drives {

inline constexpr std::size_t kMostFrames = 64;

class CanSocket {
 public:
  enum class Sent : std::uint8_t {
    kAll,
    kFull,  // the queue is full (ENOBUFS): saturated, or nobody acknowledges
    kDown,  // the interface is down or gone
  };
  struct Received {
    CanFrame frame;
    std::uint64_t stamp_us = 0;  // on the clock of now_us
    bool bus_off = false;        // an error frame of the controller; `frame` is empty
  };

  explicit CanSocket(Descriptor socket);

  // At most kMostFrames; more are an error of the caller and are not sent.
  [[nodiscard]] Sent send(std::span<const CanFrame> frames) noexcept;
  // What has come since, oldest first; empty: nothing. Valid until the next call.
  [[nodiscard]] std::span<const Received> receive(std::uint64_t now_us) noexcept;

  [[nodiscard]] int get() const { return socket_.get(); }

 private:
  struct Slot {
    canfd_frame raw;
    iovec vector;
    alignas(cmsghdr) std::array<std::byte, 64> control;
  };

  Descriptor socket_;
  std::array<Slot, kMostFrames> out_{}, in_{};
  std::array<mmsghdr, kMostFrames> headers_{};
  std::array<Received, kMostFrames> received_{};
};

}  // namespace thimble::board::drives
