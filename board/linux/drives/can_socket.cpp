#include "board/linux/drives/can_socket.h"

#include <linux/can/error.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include "firmware/link/socketcan.h"

namespace thimble::board::drives {
namespace {

std::int64_t us_of(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000 + time.tv_nsec / 1000;
}

// How long ago the kernel stamped it; 0: it did not.
std::int64_t age_us(msghdr& message, std::int64_t real_now_us) {
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(part), sizeof(stamp));
    const std::int64_t age = real_now_us - us_of(stamp);
    return age > 0 ? age : 0;
  }
  return 0;
}

}  // namespace

CanSocket::CanSocket(Descriptor socket) : socket_(std::move(socket)) {}

CanSocket::Sent CanSocket::send(std::span<const CanFrame> frames) noexcept {
  const std::size_t count = frames.size();
  if (count == 0) return Sent::kAll;
  if (count > kMostFrames) return Sent::kFull;
  for (std::size_t i = 0; i < count; ++i) {
    out_[i].vector = {&out_[i].raw, firmware::link::to_socketcan(frames[i], out_[i].raw)};
    headers_[i] = {};
    headers_[i].msg_hdr.msg_iov = &out_[i].vector;
    headers_[i].msg_hdr.msg_iovlen = 1;
  }
  const int sent =
      sendmmsg(socket_.get(), headers_.data(), static_cast<unsigned>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (std::cmp_equal(sent, count)) return Sent::kAll;
  // A part was sent: the queue has filled up.
  const bool full = sent >= 0 || errno == ENOBUFS || errno == EAGAIN || errno == EINTR;
  return full ? Sent::kFull : Sent::kDown;
}

std::span<const CanSocket::Received> CanSocket::receive(std::uint64_t now_us) noexcept {
  for (std::size_t i = 0; i < kMostFrames; ++i) {
    in_[i].vector = {&in_[i].raw, sizeof(in_[i].raw)};
    headers_[i] = {};
    headers_[i].msg_hdr.msg_iov = &in_[i].vector;
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_control = in_[i].control.data();
    headers_[i].msg_hdr.msg_controllen = in_[i].control.size();
  }
  const int got = recvmmsg(socket_.get(), headers_.data(), kMostFrames, MSG_DONTWAIT, nullptr);
  timespec real{};
  clock_gettime(CLOCK_REALTIME, &real);
  std::size_t count = 0;
  for (int i = 0; i < got; ++i) {
    const auto at = static_cast<std::size_t>(i);
    Received& out = received_[count];
    out.bus_off = (in_[at].raw.can_id & CAN_ERR_FLAG) != 0 && (in_[at].raw.can_id & CAN_ERR_BUSOFF) != 0;
    out.stamp_us = now_us - static_cast<std::uint64_t>(age_us(headers_[at].msg_hdr, us_of(real)));
    const bool frame = firmware::link::from_socketcan(in_[at].raw, headers_[at].msg_len, out.frame);
    if (frame || out.bus_off) ++count;
  }
  return {received_.data(), count};
}

}  // namespace thimble::board::drives
