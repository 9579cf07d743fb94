#include "host-tools/client/socketcan_transport.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "firmware/link/host_address.h"
#include "firmware/link/messages.h"
#include "firmware/link/socketcan.h"
#include "host-tools/client/descriptor.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using link::CanFrame;
using link::Micros;

constexpr Micros kFullBusDeadline_us = 2'000'000;  // after this time a frame counts as not sendable
constexpr Micros kFullQueuePause_us = 1000;        // a few frames at 500 kbit/s
constexpr int kSendBytes =
    4096;  // of frames on their way: less than the interface's queue (10 frames), so that poll() reports free space
constexpr int kReceiveBytes = 1 << 20;  // 1300 frames: more than the longest answer has

std::string how_to_bring_up(const std::string& interface, bool fd) {
  return "bring it up: `ip link set " + interface + " up type can bitrate 500000" +
         (fd ? " dbitrate 2000000 fd on" : "") + "`, with the bit rate of the bus";
}

class SocketCanTransport final : public Transport {
 public:
  // Opens; throws Error.
  SocketCanTransport(std::string interface, bool fd)
      : interface_(std::move(interface)),
        fd_frames_(fd),
        socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    check_interface();  // with any socket: this works also without the kernel's CAN modules
    Descriptor can(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
    if (can.get() < 0) {
      throw Error(ExitCode::kNotFound, "no-socketcan",
                  std::string("cannot open a CAN socket: ") + std::strerror(errno),
                  "load the kernel's modules: `modprobe -a can can-raw`");
    }
    socket_ = std::move(can);
    const can_err_mask_t errors = CAN_ERR_BUSOFF;
    bool set = set_option(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors);
    if (fd_frames_) set = set_option(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, int{1}) && set;
    static_cast<void>(set_option(SOL_SOCKET, SO_SNDBUF, kSendBytes));
    // Above the system's limit if permitted, else up to it.
    if (!set_option(SOL_SOCKET, SO_RCVBUFFORCE, kReceiveBytes))
      static_cast<void>(set_option(SOL_SOCKET, SO_RCVBUF, kReceiveBytes));
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface_.c_str()));
    if (!set || bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
      failed(errno);
  }

  void send(const CanFrame& frame) override {
    canfd_frame raw;
    const std::size_t bytes = link::to_socketcan(frame, raw);
    const Micros deadline_us = now_us() + kFullBusDeadline_us;
    while (write(socket_.get(), &raw, bytes) < 0) {
      const int error = errno;
      if (error == EINTR) continue;
      if (error != EAGAIN && error != ENOBUFS) failed(error);
      if (now_us() > deadline_us) stuck();
      // The queue of the socket is full, or that of the interface, whose free space is not reported.
      if (error == EAGAIN) {
        static_cast<void>(wait_for(socket_.get(), POLLOUT, deadline_us));
      } else {
        usleep(kFullQueuePause_us);
      }
    }
  }

  std::optional<CanFrame> receive(Micros deadline_us) override {
    while (true) {
      canfd_frame raw{};
      const ssize_t got = read(socket_.get(), &raw, sizeof(raw));
      if (got >= 0) {
        CanFrame frame;
        if (link::from_socketcan(raw, static_cast<std::size_t>(got), frame)) return frame;
        if ((raw.can_id & CAN_ERR_FLAG) != 0 && (raw.can_id & CAN_ERR_BUSOFF) != 0) bus_off();
      } else if (errno == EAGAIN) {
        if (!wait_for(socket_.get(), POLLIN, deadline_us)) return std::nullopt;
      } else if (errno != EINTR) {
        failed(errno);
      }
    }
  }

  [[nodiscard]] bool carries_fd() const override { return fd_frames_; }

  void listen_to(std::uint8_t node, std::uint8_t host) override {
    const std::array<can_filter, 4> filters = {
        {{link::EmergencyStop::kId, CAN_SFF_MASK | CAN_EFF_FLAG},
         {node, 0x7FU | CAN_EFF_FLAG},  // the real-time frames: the node is the lower half of their ids
         {link::grant_id(node) | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG},
         {link::response_id(node, host) | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG}}};
    // If it fails the other nodes' frames come through, and are passed over.
    static_cast<void>(set_option(SOL_CAN_RAW, CAN_RAW_FILTER, filters));
  }

 private:
  template <class Value>
  [[nodiscard]] bool set_option(int level, int option, const Value& value) {
    return setsockopt(socket_.get(), level, option, &value, sizeof(value)) == 0;
  }

  void check_interface() const {
    ifreq request{};
    const std::string there = "`thimble list` shows the interfaces that are up, `ip link show type can` all";
    if (interface_.size() >= sizeof(request.ifr_name) || if_nametoindex(interface_.c_str()) == 0) {
      throw Error(ExitCode::kNotFound, "no-interface", "there is no network interface " + interface_,
                  "plug in the adapter or load its driver; " + there);
    }
    std::ranges::copy(interface_, static_cast<char*>(request.ifr_name));
    if (ioctl(socket_.get(), SIOCGIFHWADDR, &request) != 0 || request.ifr_hwaddr.sa_family != ARPHRD_CAN)
      throw Error(ExitCode::kNotFound, "no-interface", interface_ + " is not a CAN interface", there);
    if (fd_frames_ && (ioctl(socket_.get(), SIOCGIFMTU, &request) != 0 || request.ifr_mtu != CANFD_MTU)) {
      throw Error(ExitCode::kUsage, "classic-interface", interface_ + " is set up for classic CAN only",
                  "write can:" + interface_ + ", or set it up for FD: `ip link set " + interface_ +
                      " down`, then " + how_to_bring_up(interface_, true));
    }
    if (ioctl(socket_.get(), SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0) down();
    // The interface is up and the controller is bus-off. IFF_RUNNING is not used: it follows up to a second late.
    if (char carrier = 0;
        std::ifstream("/sys/class/net/" + interface_ + "/carrier") >> carrier && carrier == '0')
      bus_off();
  }

  [[noreturn]] void down() const {
    throw Error(ExitCode::kLinkLost, "interface-down", "the CAN interface " + interface_ + " is down",
                how_to_bring_up(interface_, fd_frames_) + "; an upload goes on where it stopped");
  }
  [[noreturn]] void bus_off() const {
    throw Error(ExitCode::kLinkLost, "bus-off",
                "the CAN interface " + interface_ + " is bus off: too many of its frames had errors",
                "check the bit rate, the wires and the 120 ohm at both ends, then `ip link set " +
                    interface_ + " type can restart`; with `restart-ms 100` it returns by itself");
  }
  [[noreturn]] void stuck() const {
    check_interface();
    throw Error(ExitCode::kLinkLost, "bus-full",
                "the CAN interface " + interface_ +
                    " sends nothing: nobody acknowledges its frames, or others take "
                    "the whole bus",
                "check that the device has power, that both have the same bit rate, and the wires");
  }
  [[noreturn]] void failed(int error) const {
    if (error == ENETDOWN) down();
    throw Error(ExitCode::kLinkLost, "link-lost",
                "the CAN interface " + interface_ + " failed: " + std::strerror(error),
                "check that the adapter is plugged in, then repeat; an upload goes on where it stopped");
  }

  std::string interface_;
  bool fd_frames_;
  Descriptor socket_;
};

}  // namespace

std::unique_ptr<Transport> open_socketcan(const std::string& interface, bool fd) {
  return std::make_unique<SocketCanTransport>(interface, fd);
}

}  // namespace thimble::host
