#include "board/posix/can_interfaces.h"

#include <libmnl/libmnl.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

namespace thimble::board {
namespace {

// The attributes of one level, by their numbers; unknown ones are skipped.
template <std::size_t kCount>
using Attributes = std::array<const nlattr*, kCount>;

template <std::size_t kCount>
int keep_attribute(const nlattr* attribute, void* all) {
  const std::size_t type = mnl_attr_get_type(attribute);
  if (type < kCount) (*static_cast<Attributes<kCount>*>(all))[type] = attribute;
  return MNL_CB_OK;
}

template <std::size_t kCount>
Attributes<kCount> nested(const nlattr* outer) {
  Attributes<kCount> all{};
  if (outer != nullptr) mnl_attr_parse_nested(outer, keep_attribute<kCount>, &all);
  return all;
}

// A structure of the kernel; an older kernel sends only its first part.
template <class Struct>
Struct structure(const nlattr* attribute) {
  Struct value{};
  if (attribute != nullptr)
    std::memcpy(&value, mnl_attr_get_payload(attribute),
                std::min<std::size_t>(sizeof(value), mnl_attr_get_payload_len(attribute)));
  return value;
}

BusState bus_state(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_WARNING:
      return BusState::kErrorWarning;
    case CAN_STATE_ERROR_PASSIVE:
      return BusState::kErrorPassive;
    case CAN_STATE_BUS_OFF:
      return BusState::kBusOff;
    case CAN_STATE_STOPPED:
      return BusState::kStopped;
    case CAN_STATE_SLEEPING:
      return BusState::kSleeping;
    default:
      return BusState::kErrorActive;
  }
}

CanController read_controller(const nlattr* data) {
  const auto all = nested<IFLA_CAN_MAX + 1>(data);
  CanController controller;
  const auto timing = structure<can_bittiming>(all[IFLA_CAN_BITTIMING]);
  controller.bit_rate = timing.bitrate;
  controller.sample_point = timing.sample_point;
  controller.data_bit_rate = structure<can_bittiming>(all[IFLA_CAN_DATA_BITTIMING]).bitrate;
  controller.state = bus_state(structure<std::uint32_t>(all[IFLA_CAN_STATE]));
  controller.restart_ms = structure<std::uint32_t>(all[IFLA_CAN_RESTART_MS]);
  controller.listen_only =
      (structure<can_ctrlmode>(all[IFLA_CAN_CTRLMODE]).flags & CAN_CTRLMODE_LISTENONLY) != 0;
  const auto errors = structure<can_berr_counter>(all[IFLA_CAN_BERR_COUNTER]);
  controller.transmit_errors = errors.txerr;
  controller.receive_errors = errors.rxerr;
  return controller;
}

// One interface of the kernel's answer.
int keep_interface(const nlmsghdr* message, void* found) {
  const auto* link = static_cast<const ifinfomsg*>(mnl_nlmsg_get_payload(message));
  if (link->ifi_type != ARPHRD_CAN) return MNL_CB_OK;
  Attributes<IFLA_MAX + 1> all{};
  mnl_attr_parse(message, sizeof(*link), keep_attribute<IFLA_MAX + 1>, &all);
  CanInterface interface;
  if (all[IFLA_IFNAME] != nullptr) interface.name = mnl_attr_get_str(all[IFLA_IFNAME]);
  interface.up = (link->ifi_flags & IFF_UP) != 0;
  interface.fd = structure<std::uint32_t>(all[IFLA_MTU]) >= CANFD_MTU;
  interface.queue_frames = structure<std::uint32_t>(all[IFLA_TXQLEN]);
  const auto info = nested<IFLA_INFO_MAX + 1>(all[IFLA_LINKINFO]);
  if (info[IFLA_INFO_KIND] != nullptr && info[IFLA_INFO_DATA] != nullptr &&
      std::strcmp(mnl_attr_get_str(info[IFLA_INFO_KIND]), "can") == 0)
    interface.controller = read_controller(info[IFLA_INFO_DATA]);
  static_cast<std::vector<CanInterface>*>(found)->push_back(std::move(interface));
  return MNL_CB_OK;
}

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category(), "netlink"); }

}  // namespace

std::vector<CanInterface> read_can_interfaces() {
  const std::unique_ptr<mnl_socket, int (*)(mnl_socket*)> socket(
      mnl_socket_open2(NETLINK_ROUTE, SOCK_CLOEXEC), mnl_socket_close);
  if (!socket || mnl_socket_bind(socket.get(), 0, MNL_SOCKET_AUTOPID) < 0) fail();
  std::array<char, 32768> buffer{};  // what the kernel fills at most with one part of its answer
  nlmsghdr* request = mnl_nlmsg_put_header(buffer.data());
  request->nlmsg_type = RTM_GETLINK;
  request->nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
  request->nlmsg_seq = 1;
  auto* all = static_cast<ifinfomsg*>(mnl_nlmsg_put_extra_header(request, sizeof(ifinfomsg)));
  all->ifi_family = AF_UNSPEC;
  if (mnl_socket_sendto(socket.get(), request, request->nlmsg_len) < 0) fail();
  std::vector<CanInterface> found;
  for (int more = MNL_CB_OK; more == MNL_CB_OK;) {
    const ssize_t bytes = mnl_socket_recvfrom(socket.get(), buffer.data(), buffer.size());
    if (bytes < 0) fail();
    more = mnl_cb_run(buffer.data(), static_cast<std::size_t>(bytes), 1, mnl_socket_get_portid(socket.get()),
                      keep_interface, &found);
    if (more < 0) fail();
  }
  std::ranges::sort(found, {}, &CanInterface::name);
  return found;
}

}  // namespace thimble::board
