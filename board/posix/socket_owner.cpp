#include "board/posix/socket_owner.h"

#include <libmnl/libmnl.h>
#include <linux/inet_diag.h>
#include <linux/sock_diag.h>
#include <sys/socket.h>

#include <array>
#include <memory>

namespace thimble::board {
namespace {

int keep_owner(const nlmsghdr* message, void* found) {
  if (mnl_nlmsg_get_payload_len(message) < sizeof(inet_diag_msg)) return MNL_CB_STOP;
  const auto* socket = static_cast<const inet_diag_msg*>(mnl_nlmsg_get_payload(message));
  // Without an inode no process has it open, and its user is given as 0.
  if (socket->idiag_inode != 0) *static_cast<std::optional<uid_t>*>(found) = socket->idiag_uid;
  return MNL_CB_STOP;
}

}  // namespace

std::optional<uid_t> socket_owner(const sockaddr_in& local, const sockaddr_in& remote) {
  const std::unique_ptr<mnl_socket, int (*)(mnl_socket*)> kernel(
      mnl_socket_open2(NETLINK_SOCK_DIAG, SOCK_CLOEXEC), mnl_socket_close);
  if (!kernel || mnl_socket_bind(kernel.get(), 0, MNL_SOCKET_AUTOPID) < 0) return std::nullopt;
  alignas(nlmsghdr) std::array<char, 8192> buffer{};
  nlmsghdr* request = mnl_nlmsg_put_header(buffer.data());
  request->nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request->nlmsg_flags = NLM_F_REQUEST;
  request->nlmsg_seq = 1;
  auto* wanted =
      static_cast<inet_diag_req_v2*>(mnl_nlmsg_put_extra_header(request, sizeof(inet_diag_req_v2)));
  wanted->sdiag_family = AF_INET;
  wanted->sdiag_protocol = IPPROTO_TCP;
  wanted->idiag_states = ~0U;
  wanted->id.idiag_sport = local.sin_port;
  wanted->id.idiag_dport = remote.sin_port;
  wanted->id.idiag_src[0] = local.sin_addr.s_addr;
  wanted->id.idiag_dst[0] = remote.sin_addr.s_addr;
  wanted->id.idiag_cookie[0] = wanted->id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  if (mnl_socket_sendto(kernel.get(), request, request->nlmsg_len) < 0) return std::nullopt;
  const ssize_t bytes = mnl_socket_recvfrom(kernel.get(), buffer.data(), buffer.size());
  std::optional<uid_t> owner;
  if (bytes > 0)
    mnl_cb_run(buffer.data(), static_cast<std::size_t>(bytes), 1, mnl_socket_get_portid(kernel.get()),
               keep_owner, &owner);
  return owner;
}

}  // namespace thimble::board
