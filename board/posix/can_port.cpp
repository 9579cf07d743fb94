#include "board/posix/can_port.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "board/posix/can_interfaces.h"
#include "firmware/link/host_address.h"
#include "firmware/link/messages.h"
#include "firmware/link/socketcan.h"

namespace thimble::board {
namespace {

namespace link = firmware::link;

constexpr std::size_t kRealTimeFrames = 32;  // queue length; when full, the oldest frame is dropped
constexpr std::size_t kServiceFrames =
    2048;  // three of the longest PDUs in classic frames; when exceeded, all are dropped
constexpr unsigned kReadAtOnce = 1024;  // frames a read()
constexpr int kSocketBytes =
    4096;  // send buffer of the socket: fewer frames than the interface's queue holds (10)
constexpr int kReceiveBytes = 1 << 20;  // 1300 frames: two of the longest requests in classic ones
constexpr std::chrono::milliseconds kTryCanAgain(250);
constexpr std::chrono::milliseconds kStuckAfter(1000);  // frames that wait longer are useless

[[noreturn]] void fail_can(const std::string& interface, const std::string& why, const std::string& remedy) {
  throw std::runtime_error("cannot use the CAN interface " + interface + ": " + why + ": " + remedy);
}

template <class Value>
void set(int socket, int option, const Value& value) {
  if (setsockopt(socket, SOL_CAN_RAW, option, &value, sizeof(value)) != 0)
    throw std::runtime_error(std::string("cannot set up a CAN socket: ") + std::strerror(errno));
}

}  // namespace

CanPort::CanPort(std::string interface, std::uint8_t node) : interface_(std::move(interface)), node_(node) {
  open_socket();
}

void CanPort::open_socket() {
  ifreq request{};
  if (interface_.empty() || interface_.size() >= sizeof(request.ifr_name))
    fail_can(interface_, "it does not exist", "`ip link show type can` lists the CAN interfaces");
  Descriptor opened(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!opened.is_open())
    fail_can(interface_, std::strerror(errno), "load the kernel's modules can and can-raw");
  std::ranges::copy(interface_, static_cast<char*>(request.ifr_name));
  if (ioctl(opened.get(), SIOCGIFMTU, &request) != 0)
    fail_can(interface_, std::strerror(errno), "`ip link show type can` lists the CAN interfaces");
  fd_frames_ = request.ifr_mtu == CANFD_MTU;

  // The e-stop frame: with or without data, remote or not, from any sender.
  const std::array<can_filter, 4> filters = {
      {{link::EmergencyStop::kId, CAN_SFF_MASK | CAN_EFF_FLAG},
       {std::uint32_t{link::ForceOrder::kId} + node_, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG},
       {link::claim_id(node_) | CAN_EFF_FLAG, link::kClaimMask | CAN_EFF_FLAG | CAN_RTR_FLAG},
       {link::request_id(node_) | CAN_EFF_FLAG, link::kRequestMask | CAN_EFF_FLAG | CAN_RTR_FLAG}}};
  set(opened.get(), CAN_RAW_FILTER, filters);
  set(opened.get(), CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_BUSOFF | CAN_ERR_RESTARTED});
  if (fd_frames_) set(opened.get(), CAN_RAW_FD_FRAMES, int{1});
  setsockopt(opened.get(), SOL_SOCKET, SO_SNDBUF, &kSocketBytes, sizeof(kSocketBytes));
  // SO_RCVBUFFORCE may exceed the system's limit, but needs a privilege.
  if (setsockopt(opened.get(), SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBytes, sizeof(kReceiveBytes)) != 0)
    setsockopt(opened.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBytes, sizeof(kReceiveBytes));

  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface_.c_str()));
  if (bind(opened.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    fail_can(interface_, std::strerror(errno), "`ip link show type can` lists the CAN interfaces");
  const bool up = ioctl(opened.get(), SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
  state_ = up ? State::kUp : State::kDown;
  socket_ = std::move(opened);
}

std::vector<std::string> CanPort::uris() const {
  if (fd_frames_) return {"canfd:" + interface_, "can:" + interface_};
  return {"can:" + interface_};
}

void CanPort::add_to(std::vector<pollfd>& polled) const {
  if (!socket_.is_open()) return;
  polled.push_back({socket_.get(), static_cast<short>(waiting() && !full_ ? POLLIN | POLLOUT : POLLIN), 0});
}

void CanPort::read() {
  if (!socket_.is_open()) {
    const auto now = std::chrono::steady_clock::now();
    if (now < try_again_) return;
    try_again_ = now + kTryCanAgain;
    try {
      open_socket();
    } catch (const std::runtime_error&) {
      return;  // trouble() reports it
    }
  }
  for (unsigned i = 0; i < kReadAtOnce; ++i) {
    canfd_frame raw{};
    const ssize_t got = ::read(socket_.get(), &raw, sizeof(raw));
    if (got < 0) {
      if (errno != EAGAIN && errno != EINTR) on_failure(errno);
      return;
    }
    link::CanFrame frame;
    if ((raw.can_id & CAN_ERR_FLAG) != 0) {
      on_error_frame(raw.can_id);
      if (state_ == State::kBusOff) return;  // trouble() reports it before a frame that follows ends it
    } else if (link::from_socketcan(raw, static_cast<std::size_t>(got), frame)) {
      state_ = State::kUp;
      received_.push_back(frame);
    }
  }
}

void CanPort::on_error_frame(std::uint32_t classes) {
  if ((classes & CAN_ERR_BUSOFF) != 0) {
    state_ = State::kBusOff;
    drop_all();
  }
  if ((classes & CAN_ERR_RESTARTED) != 0) state_ = State::kUp;
}

void CanPort::on_failure(int error) {
  if (error == ENETDOWN) {
    state_ = State::kDown;
  } else {  // ENODEV, ENXIO: unplugged
    state_ = State::kGone;
    socket_ = Descriptor();
  }
  drop_all();
}

void CanPort::drop_all() {
  dropped_ += real_time_.size() + services_.size();
  real_time_.clear();
  services_.clear();
}

std::optional<link::CanFrame> CanPort::receive() {
  if (received_.empty()) return std::nullopt;
  const link::CanFrame frame = received_.front();
  received_.pop_front();
  return frame;
}

void CanPort::send(const link::CanFrame& frame) {
  if (state_ == State::kBusOff || state_ == State::kGone || (frame.fd && !fd_frames_)) {
    ++dropped_;
    return;
  }
  if (!frame.extended) {
    real_time_.push_back(frame);
    if (real_time_.size() > kRealTimeFrames) {
      real_time_.pop_front();
      ++dropped_;
    }
  } else {
    services_.push_back(frame);
    if (services_.size() > kServiceFrames) {  // the rest of an incomplete PDU is useless
      dropped_ += services_.size();
      services_.clear();
    }
  }
}

// False: it cannot be sent now.
bool CanPort::write(const link::CanFrame& frame) {
  canfd_frame raw;
  const std::size_t bytes = link::to_socketcan(frame, raw);
  const ssize_t put = ::write(socket_.get(), &raw, bytes);
  full_ = put < 0 && errno == ENOBUFS;
  if (put < 0) {
    if (errno != ENOBUFS && errno != EAGAIN && errno != EINTR) on_failure(errno);
    return false;
  }
  state_ = State::kUp;
  return true;
}

void CanPort::flush() {
  const auto now = std::chrono::steady_clock::now();
  if (!waiting()) free_ = now;
  for (Frames* frames : {&real_time_, &services_}) {
    while (!frames->empty() && write(frames->front())) {
      frames->pop_front();
      free_ = now;
    }
  }
  if (waiting() && now - free_ > kStuckAfter) {
    state_ = State::kStuck;
    drop_all();
  }
}

std::uint32_t CanPort::classic_bits_per_s() const {
  if (fd_frames_) return 0;
  try {
    for (const CanInterface& interface : read_can_interfaces())
      if (interface.name == interface_ && interface.controller) return interface.controller->bit_rate;
  } catch (const std::system_error&) {  // a sandbox without netlink: not known
  }
  return 0;
}

std::string CanPort::trouble() const {
  switch (state_) {
    case State::kUp:
      return {};
    case State::kDown:
      return interface_ + " is down";
    case State::kBusOff:
      return interface_ + " is bus off: it waits for its restart";
    case State::kStuck:
      return interface_ + " sends nothing: nobody acknowledges its frames";
    case State::kGone:
      return interface_ + " is gone";
  }
  return {};
}

}  // namespace thimble::board
