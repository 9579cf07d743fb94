// The user behind a TCP socket of this machine, as the kernel tells over netlink (inet_diag).
#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <optional>

namespace thimble::board {

// Of the socket that has this local and this remote address; remote 0.0.0.0:0: of the one that listens. Nothing: there is no such
// socket, its process has closed it, or the kernel does not tell.
[[nodiscard]] std::optional<uid_t> socket_owner(const sockaddr_in& local, const sockaddr_in& remote);

}  // namespace thimble::board
