#include "board/posix/slcan_stream.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace thimble::board {
namespace {

namespace link = firmware::link;
using link::SlcanParser;

constexpr std::size_t kTelemetryQueue = std::size_t{64}
                                        << 10U;               // bytes; beyond it real-time frames are dropped
constexpr std::size_t kServiceQueue = std::size_t{1} << 20U;  // beyond it the channel is closed

// Without the signal that a socket whose other end left would raise.
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
  } else if (got == 0 || (errno != EAGAIN && errno != EINTR)) {
    gone_ = true;
  }
}

std::optional<link::CanFrame> SlcanStream::receive() {
  while (in_at_ < in_.size()) {
    switch (parser_.push(in_[in_at_++])) {
      case SlcanParser::Event::kFrame:
        if (open_) return parser_.frame();
        out_ += '\a';
        break;
      case SlcanParser::Event::kCommand:
        command();
        break;
      case SlcanParser::Event::kBad:
        out_ += '\a';
        break;
      case SlcanParser::Event::kNone:
      case SlcanParser::Event::kAck:
      case SlcanParser::Event::kRefused:
        break;
    }
  }
  in_.clear();
  in_at_ = 0;
  return std::nullopt;
}

void SlcanStream::command() {
  switch (parser_.command()[0]) {
    case 'O':
      open_ = true;
      out_ += '\r';
      break;
    case 'C':
      open_ = false;
      out_.clear();  // what waited was for the one who left
      out_ += '\r';
      break;
    case 'S':  // any bit rate: there is no bus
    case 's':
    case 'Y':
      out_ += '\r';
      break;
    case 'V':
      out_ += "V1013\r";
      break;
    case 'N':
      out_ += "NTHIM\r";
      break;
    case 'F':
      out_ += "F00\r";
      break;
    default:
      out_ += '\a';
  }
}

void SlcanStream::send(const link::CanFrame& frame) {
  if (!open_ || gone_) return;
  if (!frame.extended && out_.size() > kTelemetryQueue) {
    ++dropped_;
    return;
  }
  if (out_.size() > kServiceQueue) {  // until somebody opens it again
    open_ = false;
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
