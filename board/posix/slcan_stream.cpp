#include "board/posix/slcan_stream.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace thimble::board {
namespace {

namespace link = firmware::link;
using link::SlcanPort;

constexpr std::size_t kTelemetryQueue = std::size_t{64}
                                        << 10U;  // bytes; when exceeded, real-time frames are dropped
constexpr std::size_t kServiceQueue = std::size_t{1} << 20U;  // when exceeded, the channel is closed

// MSG_NOSIGNAL: no SIGPIPE when the other end of a socket is closed.
ssize_t write_quietly(int fd, const std::string& bytes) {
  const ssize_t put = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return put < 0 && errno == ENOTSOCK ? write(fd, bytes.data(), bytes.size()) : put;
}

}  // namespace

pollfd SlcanStream::polled() const {
  return {fd_.get(), static_cast<short>(out_.empty() ? POLLIN : POLLIN | POLLOUT), 0};
}

void SlcanStream::read() {
  std::array<char, 16384> bytes{};
  const ssize_t got = ::read(fd_.get(), bytes.data(), bytes.size());
  if (got > 0) {
    in_.append(bytes.data(), static_cast<std::size_t>(got));
    heard_ = std::chrono::steady_clock::now();
  } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
    gone_ = true;
  }
}

void SlcanStream::drop() {
  gone_ = true;
  in_.clear();
  in_at_ = 0;
  out_.clear();
}

std::optional<link::CanFrame> SlcanStream::receive() {
  while (in_at_ < in_.size()) {
    const char byte = in_[in_at_++];
    if (byte == ' ' && kind_ != Kind::kTerminal) {
      drop();
      break;
    }
    const SlcanPort::Event event = port_.push(byte);
    if (event == SlcanPort::Event::kFrame) return port_.frame();
    if (kind_ == Kind::kStopsOnly) {
      if (port_.open()) port_ = {};
      continue;
    }
    if (event == SlcanPort::Event::kClosed) out_.clear();
    out_ += port_.reply();
    if (out_.size() > kServiceQueue) drop();  // it asks, and reads no answer
  }
  in_.clear();
  in_at_ = 0;
  return std::nullopt;
}

void SlcanStream::send(const link::CanFrame& frame) {
  if (!port_.open() || gone_) return;
  if (!frame.extended && out_.size() > kTelemetryQueue) {
    ++dropped_;
    return;
  }
  if (out_.size() > kServiceQueue) {  // until the host opens the channel again
    port_.close();
    out_.clear();
    return;
  }
  link::SlcanLine line;
  const std::size_t size = link::encode_slcan(frame, line);
  out_.append(line.data(), size);
}

void SlcanStream::flush() {
  while (!out_.empty()) {
    const ssize_t put = write_quietly(fd_.get(), out_);
    if (put <= 0) {
      if (put < 0 && errno != EAGAIN && errno != EINTR) gone_ = true;
      break;
    }
    out_.erase(0, static_cast<std::size_t>(put));
  }
  if (gone_) out_.clear();
}

}  // namespace thimble::board
