#include "board/sim/link_ports.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace thimble::board {
namespace {

namespace fs = std::filesystem;
namespace link = firmware::link;
using link::SlcanParser;

constexpr std::size_t kTelemetryQueue = std::size_t{64}
                                        << 10U;               // bytes; beyond it real-time frames are dropped
constexpr std::size_t kServiceQueue = std::size_t{1} << 20U;  // beyond it a client is given up

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

}  // namespace

void LinkPorts::open_pty(const std::string& link_path) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (master < 0) fail("cannot open a pty");
  auto client = std::make_unique<Client>();
  client->fd = master;
  client->pty = true;
  clients_.push_back(std::move(client));
  std::array<char, 128> name{};
  if (grantpt(master) != 0 || unlockpt(master) != 0 || ptsname_r(master, name.data(), name.size()) != 0) {
    fail("cannot open a pty");
  }
  pty_slave_ = open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  if (pty_slave_ < 0 || tcgetattr(pty_slave_, &settings) != 0)
    fail(std::string("cannot open ") + name.data());
  cfmakeraw(&settings);
  tcsetattr(pty_slave_, TCSANOW, &settings);

  std::string path = name.data();
  if (!link_path.empty()) {
    std::error_code failed;
    if (fs::is_symlink(link_path, failed)) fs::remove(link_path, failed);  // what a killed simulator left
    fs::create_symlink(path, link_path, failed);
    if (failed) throw std::runtime_error("cannot make the link " + link_path + ": " + failed.message());
    link_ = link_path;
    path = fs::absolute(link_path).string();
  }
  uris_.push_back("slcan:" + path);
}

void LinkPorts::open_tcp(std::uint16_t port) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0) fail("cannot open a TCP socket");
  const int on = 1;
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_, generic, sizeof(address)) != 0 || listen(listener_, 8) != 0) {
    if (errno == EADDRINUSE) {
      throw std::runtime_error("TCP port " + std::to_string(port) +
                               " is in use: end what uses it, choose another, or --tcp 0 for any");
    }
    fail("cannot listen on TCP port " + std::to_string(port));
  }
  socklen_t size = sizeof(address);
  getsockname(listener_, generic, &size);
  // First: it carries more than a pty, whose buffer is 4 kB.
  uris_.insert(uris_.begin(), "tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
}

LinkPorts::~LinkPorts() {
  for (const auto& client : clients_) close(client->fd);
  if (pty_slave_ >= 0) close(pty_slave_);
  if (listener_ >= 0) close(listener_);
  std::error_code ignored;
  if (!link_.empty()) fs::remove(link_, ignored);
}

void LinkPorts::wait(std::uint64_t timeout_us) {
  std::vector<pollfd> entries;
  entries.reserve(clients_.size() + 1);
  for (const auto& client : clients_) {
    entries.push_back({client->fd, static_cast<short>(client->out.empty() ? POLLIN : POLLIN | POLLOUT), 0});
  }
  if (listener_ >= 0) entries.push_back({listener_, POLLIN, 0});
  const timespec timeout{static_cast<time_t>(timeout_us / 1'000'000),
                         static_cast<long>(timeout_us % 1'000'000 * 1000)};
  if (ppoll(entries.data(), entries.size(), &timeout, nullptr) <= 0) return;
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    if ((entries[i].revents & (POLLIN | POLLHUP | POLLERR)) != 0) read_from(*clients_[i]);
  }
  accept_clients();
  std::erase_if(clients_, [](const std::unique_ptr<Client>& client) {
    const bool gone = client->dead && !client->pty;
    if (gone) close(client->fd);
    return gone;
  });
}

void LinkPorts::accept_clients() {
  if (listener_ < 0) return;
  const int fd = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) return;
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  auto client = std::make_unique<Client>();
  client->fd = fd;
  clients_.push_back(std::move(client));
}

void LinkPorts::read_from(Client& client) {
  std::array<char, 16384> bytes{};
  const ssize_t got = read(client.fd, bytes.data(), bytes.size());
  if (got > 0) {
    client.in.append(bytes.data(), static_cast<std::size_t>(got));
  } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
    client.dead = true;
  }
}

std::optional<link::CanFrame> LinkPorts::receive() {
  for (const auto& client : clients_) {
    while (client->in_at < client->in.size()) {
      switch (client->parser.push(client->in[client->in_at++])) {
        case SlcanParser::Event::kFrame:
          if (client->open) return client->parser.frame();
          client->out += '\a';
          break;
        case SlcanParser::Event::kCommand:
          command(*client);
          break;
        case SlcanParser::Event::kBad:
          client->out += '\a';
          break;
        case SlcanParser::Event::kNone:
        case SlcanParser::Event::kAck:
        case SlcanParser::Event::kRefused:
          break;
      }
    }
    client->in.clear();
    client->in_at = 0;
  }
  return std::nullopt;
}

void LinkPorts::command(Client& client) {
  switch (client.parser.command()[0]) {
    case 'O':
      client.open = true;
      client.out += '\r';
      break;
    case 'C':
      client.open = false;
      client.out.clear();  // what waited was for the one who left
      client.out += '\r';
      break;
    case 'S':  // any bit rate: there is no bus
    case 's':
    case 'Y':
      client.out += '\r';
      break;
    case 'V':
      client.out += "V1013\r";
      break;
    case 'N':
      client.out += "NTHIM\r";
      break;
    case 'F':
      client.out += "F00\r";
      break;
    default:
      client.out += '\a';
  }
}

void LinkPorts::send(const link::CanFrame& frame) {
  link::SlcanLine line;
  const std::size_t size = link::encode_slcan(frame, line);
  for (const auto& client : clients_) {
    if (!client->open || client->dead) continue;
    if (!frame.extended && client->out.size() > kTelemetryQueue) {
      ++dropped_;
    } else if (client->out.size() > kServiceQueue) {
      client->dead = true;
      client->open = false;
    } else {
      client->out.append(line.data(), size);
    }
  }
}

void LinkPorts::flush() {
  for (const auto& client : clients_) {
    while (!client->out.empty()) {
      const ssize_t put = client->pty
                              ? write(client->fd, client->out.data(), client->out.size())
                              : ::send(client->fd, client->out.data(), client->out.size(), MSG_NOSIGNAL);
      if (put <= 0) {
        if (put < 0 && errno != EAGAIN && errno != EINTR) client->dead = true;
        break;
      }
      client->out.erase(0, static_cast<std::size_t>(put));
    }
    if (client->dead) client->out.clear();
  }
}

}  // namespace thimble::board
