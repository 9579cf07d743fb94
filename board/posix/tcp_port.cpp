#include "board/posix/tcp_port.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "board/posix/socket_owner.h"

namespace thimble::board {
namespace {

constexpr std::size_t kMostHosts = 32;
constexpr int kAcceptsARead = 16;

[[noreturn]] void fail_tcp(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

}  // namespace

TcpPort::TcpPort(std::uint16_t port, Hosts hosts)
    : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), may_connect_(hosts) {
  if (!listener_.is_open()) fail_tcp("cannot open a TCP socket");
  const int on = 1;
  setsockopt(listener_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  address_.sin_family = AF_INET;
  address_.sin_port = htons(port);
  address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* generic = reinterpret_cast<sockaddr*>(&address_);
  if (bind(listener_.get(), generic, sizeof(address_)) != 0 || listen(listener_.get(), SOMAXCONN) != 0) {
    if (errno == EADDRINUSE) {
      throw std::runtime_error(
          "TCP port " + std::to_string(port) +
          " is in use: end the other program, or choose another port (0: any free port)");
    }
    fail_tcp("cannot listen on TCP port " + std::to_string(port));
  }
  socklen_t size = sizeof(address_);
  getsockname(listener_.get(), generic, &size);
  uri_ = "tcp:127.0.0.1:" + std::to_string(ntohs(address_.sin_port));
}

void TcpPort::add_to(std::vector<pollfd>& polled) const {
  polled.push_back({listener_.get(), POLLIN, 0});
  for (const auto& host : hosts_) polled.push_back(host->polled());
}

void TcpPort::read() {
  for (const auto& host : hosts_) {
    host->read();
    if (host->gone()) dropped_ += host->dropped();
  }
  std::erase_if(hosts_, [](const std::unique_ptr<SlcanStream>& host) { return host->gone(); });
  ended_.clear();
  for (int i = 0; i < kAcceptsARead && accept_host(); ++i) {
  }
}

void TcpPort::tell_refused(uid_t owner) {
  constexpr auto kTellEvery = std::chrono::seconds(1);
  const auto now = std::chrono::steady_clock::now();
  if (now < tell_again_) return;
  tell_again_ = now + kTellEvery;
  std::cerr << program_invocation_short_name << ": a connection to " << uri_
            << " was refused: it is of the user " << owner << ", and only the user " << geteuid()
            << " may connect (--open: everyone)" << std::endl;
}

bool TcpPort::accept_host() {
  sockaddr_in peer{};
  socklen_t size = sizeof(peer);
  Descriptor fd(
      accept4(listener_.get(), reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!fd.is_open()) return false;
  const std::optional<uid_t> owner =
      may_connect_ == Hosts::kEveryone ? geteuid() : socket_owner(peer, address_);
  if (owner && *owner != geteuid()) {
    tell_refused(*owner);
    return true;
  }
  if (!owner) {  // nobody's: a program that sent a stop and has ended already
    ended_.push_back(std::make_unique<SlcanStream>(std::move(fd), SlcanStream::Kind::kStopsOnly));
    ended_.back()->read();
    return true;
  }
  const int on = 1;
  setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  hosts_.push_back(std::make_unique<SlcanStream>(std::move(fd), SlcanStream::Kind::kSocket));
  if (hosts_.size() <= kMostHosts) return true;
  const auto silent = std::ranges::min_element(hosts_, {}, [](const auto& host) { return host->heard(); });
  dropped_ += (*silent)->dropped();
  hosts_.erase(silent);
  return true;
}

std::optional<firmware::link::CanFrame> TcpPort::receive() {
  for (const auto* streams : {&hosts_, &ended_})
    for (const auto& host : *streams)
      if (const auto frame = host->receive()) return frame;
  return std::nullopt;
}

void TcpPort::send(const firmware::link::CanFrame& frame) {
  for (const auto& host : hosts_) host->send(frame);
}

void TcpPort::flush() {
  for (const auto& host : hosts_) host->flush();
}

bool TcpPort::waiting() const {
  return std::ranges::any_of(hosts_, [](const auto& host) { return host->waiting(); });
}

std::uint64_t TcpPort::dropped() const {
  std::uint64_t frames = dropped_;
  for (const auto& host : hosts_) frames += host->dropped();
  return frames;
}

}  // namespace thimble::board
