// can_client INTERFACE BITRATE IMAGE: a session over SocketCAN with what `thimble` is made of (host-tools/client), for a machine that has few
// libraries: brings the interface up, uploads, homes, arms, waits for a force, disarms. Linked statically for the guest of linux_test.py.
//
// Prints one line a step. Exit codes: 0; those of docs/cli.md for what the device said; 1 anything else.
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "firmware/link/messages.h"
#include "host-tools/client/device.h"
#include "host-tools/client/transport.h"
#include "host-tools/error.h"

namespace thimble::tests {
namespace {

namespace link = firmware::link;

constexpr float kTouch_N = 1.0F;
constexpr link::Micros kPatience_us = 60'000'000;

// A request to the kernel about an interface, grown attribute by attribute.
class LinkRequest {
 public:
  explicit LinkRequest(unsigned index, bool up) {
    header()->nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
    header()->nlmsg_type = RTM_NEWLINK;
    header()->nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
    ifinfomsg message{};
    message.ifi_index = static_cast<int>(index);
    message.ifi_flags = up ? IFF_UP : 0;
    message.ifi_change = up ? IFF_UP : 0;
    std::memcpy(&bytes_[NLMSG_HDRLEN], &message, sizeof(message));
  }
  std::size_t add(unsigned short type, const void* data, std::size_t bytes) {
    const std::size_t at = NLMSG_ALIGN(header()->nlmsg_len);
    rtattr attribute{};
    attribute.rta_type = type;
    attribute.rta_len = static_cast<unsigned short>(RTA_LENGTH(bytes));
    std::memcpy(&bytes_[at], &attribute, sizeof(attribute));
    if (bytes > 0) std::memcpy(&bytes_[at + RTA_LENGTH(0)], data, bytes);
    header()->nlmsg_len = static_cast<std::uint32_t>(at + RTA_ALIGN(attribute.rta_len));
    return at;
  }
  // The attribute at `at` holds all that was added since.
  void close(std::size_t at) {
    const auto length = static_cast<unsigned short>(header()->nlmsg_len - at);
    std::memcpy(&bytes_[at], &length, sizeof(length));
  }
  void send(const std::string& what) {
    const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    std::array<char, 1024> answer{};
    const bool talked = ::send(fd, bytes_.data(), header()->nlmsg_len, 0) > 0 &&
                        recv(fd, answer.data(), answer.size(), 0) > 0;
    const int trouble = errno;
    ::close(fd);
    if (!talked) throw std::system_error(trouble, std::generic_category(), what);
    nlmsgerr error{};
    std::memcpy(&error, &answer[NLMSG_HDRLEN], sizeof(error));
    if (error.error != 0) throw std::system_error(-error.error, std::generic_category(), what);
  }

 private:
  nlmsghdr* header() { return reinterpret_cast<nlmsghdr*>(bytes_.data()); }
  alignas(nlmsghdr) std::array<char, 512> bytes_{};
};

void bring_up(const std::string& interface, std::uint32_t bitrate) {
  const unsigned index = if_nametoindex(interface.c_str());
  if (index == 0) throw std::runtime_error("there is no interface " + interface);
  can_bittiming timing{};
  timing.bitrate = bitrate;
  LinkRequest set(index, false);
  const std::size_t info = set.add(IFLA_LINKINFO, nullptr, 0);
  set.add(IFLA_INFO_KIND, "can", 4);
  const std::size_t data = set.add(IFLA_INFO_DATA, nullptr, 0);
  set.add(IFLA_CAN_BITTIMING, &timing, sizeof(timing));
  set.close(data);
  set.close(info);
  set.send("the bit rate");
  LinkRequest(index, true).send("bringing it up");
}

void run(const std::string& interface, std::uint32_t bitrate, const std::string& file) {
  bring_up(interface, bitrate);
  std::cout << interface << " is up at " << bitrate << std::endl;
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty()) throw std::runtime_error("cannot read " + file);

  host::DeviceOptions options;
  options.answer_us = 5'000'000;
  host::Device device(host::open_transport("can:" + interface), options);
  std::cout << "board " << device.text(link::kDidBoardName) << std::endl;
  device.clear_faults();
  const host::UploadResult uploaded =
      device.upload(std::as_bytes(std::span(bytes)), {}, [](const host::UploadProgress&) {});
  std::cout << "uploaded " << uploaded.bytes << " bytes, " << uploaded.retried_blocks << " blocks again"
            << std::endl;
  device.home();
  std::cout << "homed" << std::endl;
  device.arm(kPatience_us);
  std::cout << "armed" << std::endl;
  const link::Micros end = host::now_us() + kPatience_us;
  for (float force_N = 0; force_N < kTouch_N;) {
    const std::optional<link::CanFrame> frame = device.telemetry(end);
    if (!frame) throw std::runtime_error("no force came");
    link::Force force;
    if (link::from_frame(*frame, options.node, force)) force_N = force.z_N;
    if (force_N >= kTouch_N) std::cout << "force " << force_N << " N" << std::endl;
  }
  device.disarm();
  const link::DeviceState state = device.state();
  std::cout << "disarmed, " << state.contact_ticks << " ticks in contact, mode " << link::name(state.mode)
            << std::endl;
}

}  // namespace
}  // namespace thimble::tests

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "can_client INTERFACE BITRATE IMAGE\n";
    return 2;
  }
  try {
    thimble::tests::run(argv[1], static_cast<std::uint32_t>(std::strtoul(argv[2], nullptr, 10)), argv[3]);
    return 0;
  } catch (const thimble::host::Error& error) {
    std::cout << "can_client: " << error.what() << std::endl;
    return static_cast<int>(error.code);
  } catch (const std::exception& error) {
    std::cout << "can_client: " << error.what() << std::endl;
    return 1;
  }
}
