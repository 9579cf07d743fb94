#include "board/linux/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace thimble::board {
namespace {

// A number from the environment; 0: not set.
std::uint64_t number_in(const char* variable) noexcept {
  const char* text = std::getenv(variable);
  std::uint64_t value = 0;
  if (text != nullptr) (void)std::from_chars(text, text + std::strlen(text), value);
  return value;
}

}  // namespace

ServiceManager::ServiceManager() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  if (path == nullptr || *path == '\0') return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t length = std::strlen(path);
  if (length >= sizeof(address.sun_path))
    throw std::system_error(ENAMETOOLONG, std::generic_category(), std::string("NOTIFY_SOCKET ") + path);
  std::memcpy(address.sun_path, path, length);
  if (path[0] == '@') address.sun_path[0] = '\0';  // a socket in the abstract namespace
  socket_ = Descriptor(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  if (!socket_.is_open() || connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0)
    throw std::system_error(errno, std::generic_category(), std::string("NOTIFY_SOCKET ") + path);
  const std::uint64_t pid = number_in("WATCHDOG_PID");
  if (pid == 0 || pid == static_cast<std::uint64_t>(getpid())) watchdog_us_ = number_in("WATCHDOG_USEC");
}

void ServiceManager::tell(std::string_view state) noexcept {
  if (socket_.is_open()) (void)send(socket_.get(), state.data(), state.size(), MSG_NOSIGNAL);
}

}  // namespace thimble::board
