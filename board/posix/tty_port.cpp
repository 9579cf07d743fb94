#include "board/posix/tty_port.h"

#include <fcntl.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace thimble::board {
namespace {

constexpr std::chrono::milliseconds kTryTtyAgain(100);

}  // namespace

TtyPort::TtyPort(std::string path) : path_(std::move(path)) {
  if (open_tty()) return;
  throw std::runtime_error("cannot open the serial port " + path_ + ": " + std::strerror(errno) +
                           ": check its name, its driver and your permission");
}

bool TtyPort::open_tty() {
  Descriptor fd(open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  termios settings{};
  if (!fd.is_open() || tcgetattr(fd.get(), &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  cfsetspeed(&settings, B3000000);  // USB ignores it
  if (tcsetattr(fd.get(), TCSANOW, &settings) != 0) return false;
  stream_.emplace(std::move(fd));
  return true;
}

void TtyPort::add_to(std::vector<pollfd>& polled) const {
  if (stream_) polled.push_back(stream_->polled());
}

void TtyPort::read() {
  if (!stream_) {
    const auto now = std::chrono::steady_clock::now();
    if (now < try_again_) return;
    try_again_ = now + kTryTtyAgain;
    if (!open_tty()) return;
  }
  stream_->read();
  if (stream_->gone()) {
    dropped_ += stream_->dropped();
    stream_.reset();
  }
}

std::optional<firmware::link::CanFrame> TtyPort::receive() {
  return stream_ ? stream_->receive() : std::nullopt;
}

void TtyPort::send(const firmware::link::CanFrame& frame) {
  if (stream_) stream_->send(frame);
}

void TtyPort::flush() {
  if (stream_) stream_->flush();
}

std::uint64_t TtyPort::dropped() const { return dropped_ + (stream_ ? stream_->dropped() : 0); }

std::string TtyPort::trouble() const { return stream_ ? "" : path_ + " is gone"; }

}  // namespace thimble::board
