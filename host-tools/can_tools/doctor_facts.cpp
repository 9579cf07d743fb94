#include "host-tools/can_tools/doctor_facts.h"

#include <grp.h>
#include <libmnl/libmnl.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include "host-tools/error.h"

namespace thimble::host {
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

[[noreturn]] void netlink_failed() {
  throw Error(ExitCode::kRefused, "no-netlink",
              std::string("the kernel does not tell its network interfaces: ") + std::strerror(errno),
              "run it outside of a sandbox that forbids AF_NETLINK");
}

bool matches(const std::string& name, const std::string& prefix) {
  return name.size() > prefix.size() && name.starts_with(prefix) && name[prefix.size()] >= '0' &&
         name[prefix.size()] <= '9';
}

// A capability of this process, by its number in linux/capability.h.
bool capable(unsigned number) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "CapEff:") continue;
    std::uint64_t bits = 0;
    status >> std::hex >> bits;
    return (bits >> number & 1U) != 0;
  }
  return false;
}
constexpr unsigned kIpcLock = 14;
constexpr unsigned kSysNice = 23;

}  // namespace

std::vector<CanInterface> read_can_interfaces() {
  const std::unique_ptr<mnl_socket, int (*)(mnl_socket*)> socket(
      mnl_socket_open2(NETLINK_ROUTE, SOCK_CLOEXEC), mnl_socket_close);
  if (!socket || mnl_socket_bind(socket.get(), 0, MNL_SOCKET_AUTOPID) < 0) netlink_failed();
  std::array<char, 32768> buffer{};  // what the kernel fills at most with one part of its answer
  nlmsghdr* request = mnl_nlmsg_put_header(buffer.data());
  request->nlmsg_type = RTM_GETLINK;
  request->nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
  request->nlmsg_seq = 1;
  auto* all = static_cast<ifinfomsg*>(mnl_nlmsg_put_extra_header(request, sizeof(ifinfomsg)));
  all->ifi_family = AF_UNSPEC;
  if (mnl_socket_sendto(socket.get(), request, request->nlmsg_len) < 0) netlink_failed();
  std::vector<CanInterface> found;
  for (int more = MNL_CB_OK; more == MNL_CB_OK;) {
    const ssize_t bytes = mnl_socket_recvfrom(socket.get(), buffer.data(), buffer.size());
    if (bytes < 0) netlink_failed();
    more = mnl_cb_run(buffer.data(), static_cast<std::size_t>(bytes), 1, mnl_socket_get_portid(socket.get()),
                      keep_interface, &found);
    if (more < 0) netlink_failed();
  }
  std::ranges::sort(found, {}, &CanInterface::name);
  return found;
}

DeviceFile read_device(DeviceKind kind, const std::string& path) {
  DeviceFile device{kind, path, true, access(path.c_str(), R_OK | W_OK) == 0, "", false};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    device.exists = errno != ENOENT && errno != ENOTDIR;
    return device;
  }
  constexpr mode_t kGroupMay = S_IRGRP | S_IWGRP;
  const group* owner = getgrgid(status.st_gid);
  if ((status.st_mode & kGroupMay) != kGroupMay || owner == nullptr || status.st_gid == 0) return device;
  device.group = owner->gr_name;
  const passwd* user = getpwuid(getuid());
  for (char** member = owner->gr_mem; user != nullptr && *member != nullptr; ++member)
    device.member_by_now = device.member_by_now || std::strcmp(*member, user->pw_name) == 0;
  return device;
}

std::vector<DeviceFile> read_devices(bool board) {
  std::vector<DeviceFile> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
    const std::string name = entry.path().filename().string();
    const auto add = [&](DeviceKind kind) { found.push_back(read_device(kind, entry.path().string())); };
    if (matches(name, "ttyACM") || matches(name, "ttyUSB")) add(DeviceKind::kSerial);
    if (!board) continue;
    if (matches(name, "ttyGS")) add(DeviceKind::kSerial);
    if (matches(name, "gpiochip")) add(DeviceKind::kGpio);
    if (matches(name, "spidev")) add(DeviceKind::kSpi);
    if (matches(name, "counter")) add(DeviceKind::kCounter);
  }
  std::ranges::sort(found, {}, &DeviceFile::path);
  return found;
}

Privileges read_privileges() {
  Privileges privileges;
  rlimit limit{};
  if (capable(kSysNice)) {
    privileges.priority = 99;
  } else if (getrlimit(RLIMIT_RTPRIO, &limit) == 0) {
    privileges.priority = std::min<rlim_t>(limit.rlim_cur, 99);
  }
  if (!capable(kIpcLock) && getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    privileges.locked_bytes = limit.rlim_cur;
  return privileges;
}

bool kernel_has_can_sockets() {
  const int can = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (can >= 0) close(can);
  return can >= 0 || errno == EPERM || errno == EACCES;
}

}  // namespace thimble::host
