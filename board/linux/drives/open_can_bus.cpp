#include "board/linux/drives/open_can_bus.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace thimble::board::drives {
namespace {

template <class Value>
bool set_option(int socket, int level, int option, const Value& value) {
  return setsockopt(socket, level, option, &value, sizeof(value)) == 0;
}

OpenedBus failed(const std::string& interface, const std::string& why) {
  return {Descriptor(), "cannot use " + interface + " for drives: " + why};
}

}  // namespace

OpenedBus open_can_bus(const std::string& interface, std::span<const can_filter> filters, bool fd) {
  Descriptor opened(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!opened.is_open()) return failed(interface, std::strerror(errno));
  ifreq request{};
  if (interface.empty() || interface.size() >= sizeof(request.ifr_name))
    return failed(interface, "no such interface");
  std::ranges::copy(interface, static_cast<char*>(request.ifr_name));
  if (ioctl(opened.get(), SIOCGIFMTU, &request) != 0) return failed(interface, std::strerror(errno));
  if (fd && request.ifr_mtu != CANFD_MTU)
    return failed(interface, "it has no CAN FD: `ip link set " + interface + " up type can ... fd on`");
  const int on = 1, off = 0;
  bool good = set_option(opened.get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, off) &&
              set_option(opened.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_BUSOFF}) &&
              set_option(opened.get(), SOL_SOCKET, SO_TIMESTAMPNS, on);
  if (fd) good = good && set_option(opened.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on);
  if (!filters.empty())
    good = good && setsockopt(opened.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                              static_cast<socklen_t>(filters.size_bytes())) == 0;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (!good || bind(opened.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    return failed(interface, std::strerror(errno));
  return {std::move(opened), {}};
}

}  // namespace thimble::board::drives
