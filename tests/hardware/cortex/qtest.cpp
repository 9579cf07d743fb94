#include "tests/hardware/cortex/qtest.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace thimble::tests {

Qtest::Qtest(const std::string& socket) : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket.size() >= sizeof(address.sun_path))
    throw std::runtime_error(socket + " is too long for a socket's name");
  std::memcpy(address.sun_path, socket.data(), socket.size());
  if (connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot connect to QEMU at " + socket);
  }
}

std::string Qtest::line() {
  for (;;) {
    const std::size_t end = received_.find('\n');
    if (end != std::string::npos) {
      std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      return line;
    }
    std::array<char, 4096> bytes{};
    const ssize_t count = recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (count <= 0) throw std::runtime_error("QEMU has closed its test socket");
    received_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

void Qtest::run(std::span<Access> accesses) {
  std::string commands;
  for (const Access& access : accesses) {
    std::array<char, 48> text{};
    if (access.write) {
      std::snprintf(text.data(), text.size(), "writel 0x%x 0x%x\n", access.address, access.value);
    } else {
      std::snprintf(text.data(), text.size(), "readl 0x%x\n", access.address);
    }
    commands += text.data();
  }
  if (send(socket_.get(), commands.data(), commands.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(commands.size())) {
    throw std::runtime_error("QEMU takes no commands on its test socket");
  }
  for (Access& access : accesses) {
    const std::string answer = line();
    if (!answer.starts_with("OK")) throw std::runtime_error("QEMU's test socket: " + answer);
    if (!access.write) access.value = static_cast<std::uint32_t>(std::stoull(answer.substr(2), nullptr, 16));
  }
}

}  // namespace thimble::tests
