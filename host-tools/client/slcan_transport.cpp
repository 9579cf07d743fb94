#include "host-tools/client/slcan_transport.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "firmware/link/messages.h"
#include "firmware/link/slcan.h"
#include "host-tools/client/descriptor.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using link::CanFrame;
using link::Micros;
using link::SlcanParser;

constexpr Micros kSendDeadline_us = 2'000'000;
constexpr Micros kConnectDeadline_us = 3'000'000;
constexpr std::string_view kOpen =
    "O\r";  // also again: the device closes the channel of a program that reads nothing for long

[[noreturn]] void fail_open(const std::string& uri, int error) {
  const std::string cause = "cannot open " + uri + ": " + std::strerror(error);
  switch (error) {
    case EACCES:
    case EPERM:
      throw Error(ExitCode::kPermission, "permission", cause,
                  "join the group that owns the device (often dialout), or install the udev rule");
    case ENOENT:
    case ENODEV:
    case ENXIO:
    case ENOTTY:
    case ECONNREFUSED:
      throw Error(ExitCode::kNotFound, "no-device", cause,
                  "check the cable or start thimble-sim; `thimble list` shows what is there");
    case EBUSY:
    case EWOULDBLOCK:
      throw Error(ExitCode::kRefused, "device-in-use", cause, "end the other program that has it open");
    default:
      throw Error(ExitCode::kLinkLost, "open-failed", cause, "check the cable and the address");
  }
}

// Without SIGPIPE, which would end the program if the other end has closed the socket.
ssize_t write_quietly(int fd, std::string_view text) {
  const ssize_t put = ::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
  return put < 0 && errno == ENOTSOCK ? write(fd, text.data(), text.size()) : put;
}

// SLCAN over a descriptor that is non-blocking.
class SlcanTransport final : public Transport {
 public:
  SlcanTransport(Descriptor fd, std::string uri) : fd_(std::move(fd)), uri_(std::move(uri)) {
    // Close ends a channel that was left open, then 1 Mbit/s, then open. Each answer is one CR; the first
    // request shows whether the device answers at all.
    write_all("\rC\rS8\rO\r");
  }

  ~SlcanTransport() override {
    // Stops the frames, which would fill the buffers of an unread port. Best effort: the link may be lost.
    constexpr std::string_view kClose = "C\r";
    static_cast<void>(!write_quietly(fd_.get(), kClose));
  }

  void send(const CanFrame& frame) override {
    link::SlcanLine line;
    const std::size_t size = link::encode_slcan(frame, line);
    write_all({line.data(), size});
    // A closed channel hears it, and does not say so.
    if (!frame.extended && frame.id == link::EmergencyStop::kId) write_all(kOpen);
  }

  std::optional<CanFrame> receive(Micros deadline_us) override {
    while (true) {
      while (taken_ < filled_) {
        const SlcanParser::Event event = parser_.push(buffer_[taken_++]);
        if (event == SlcanParser::Event::kFrame) return parser_.frame();
        // What was refused is repeated by who sent it.
        if (event == SlcanParser::Event::kRefused) write_all(kOpen);
      }
      if (!wait_for(fd_.get(), POLLIN, deadline_us)) return std::nullopt;
      const ssize_t got = read(fd_.get(), buffer_.data(), buffer_.size());
      if (got > 0) {
        taken_ = 0;
        filled_ = static_cast<std::size_t>(got);
      } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
        lost(got == 0 ? "the device closed it" : std::strerror(errno));
      }
    }
  }

 private:
  [[noreturn]] void lost(const std::string& why) const {
    throw Error(ExitCode::kLinkLost, "link-lost", "the link " + uri_ + " broke: " + why,
                "check the cable and that the device runs, then repeat; an upload goes on where it stopped");
  }

  void write_all(std::string_view text) {
    const Micros deadline_us = now_us() + kSendDeadline_us;
    while (!text.empty()) {
      const ssize_t put = write_quietly(fd_.get(), text);
      if (put > 0) {
        text.remove_prefix(static_cast<std::size_t>(put));
      } else if (put < 0 && errno != EAGAIN && errno != EINTR) {
        lost(std::strerror(errno));
      } else if (!wait_for(fd_.get(), POLLOUT, deadline_us)) {
        lost("it takes no more data");
      }
    }
  }

  Descriptor fd_;
  std::string uri_;
  SlcanParser parser_;
  std::array<char, 4096> buffer_{};
  std::size_t taken_ = 0;
  std::size_t filled_ = 0;
};

}  // namespace

std::unique_ptr<Transport> open_serial(const std::string& path, const std::string& uri) {
  Descriptor fd(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.get() < 0) fail_open(uri, errno);
  if (flock(fd.get(), LOCK_EX | LOCK_NB) != 0) fail_open(uri, errno);
  termios settings{};
  if (tcgetattr(fd.get(), &settings) != 0) fail_open(uri, ENOTTY);
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  cfsetspeed(&settings, B3000000);  // a pty and USB ignore it
  if (tcsetattr(fd.get(), TCSANOW, &settings) != 0) fail_open(uri, errno);
  tcflush(fd.get(), TCIFLUSH);
  return std::make_unique<SlcanTransport>(std::move(fd), uri);
}

std::unique_ptr<Transport> open_socket(Descriptor socket, const std::string& uri) {
  return std::make_unique<SlcanTransport>(std::move(socket), uri);
}

std::unique_ptr<Transport> open_tcp(const std::string& host, const std::string& port,
                                    const std::string& uri) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int failed = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (failed != 0) {
    throw Error(ExitCode::kNotFound, "no-device", "cannot find " + uri + ": " + gai_strerror(failed),
                "check the host and port; `thimble list` shows what is there");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  int error = ECONNREFUSED;
  for (const addrinfo* address = addresses.get(); address != nullptr; address = address->ai_next) {
    Descriptor fd(socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (fd.get() < 0) continue;
    if (connect(fd.get(), address->ai_addr, address->ai_addrlen) != 0 && errno != EINPROGRESS) {
      error = errno;
      continue;
    }
    if (!wait_for(fd.get(), POLLOUT, now_us() + kConnectDeadline_us)) {
      error = ETIMEDOUT;
      continue;
    }
    socklen_t size = sizeof(error);
    getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) continue;
    const int on = 1;  // flow control is a ping-pong of small frames
    setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    return std::make_unique<SlcanTransport>(std::move(fd), uri);
  }
  fail_open(uri, error);
}

}  // namespace thimble::host
