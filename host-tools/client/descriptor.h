// A file descriptor that its owner closes, and waiting for one. For the transports in this folder.
#pragma once

#include <utility>

#include "firmware/link/can_frame.h"

namespace thimble::host {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor();
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

// Waits for readiness (poll's events) until the deadline of now_us(); false after it.
[[nodiscard]] bool wait_for(int fd, short events, firmware::link::Micros deadline_us);

}  // namespace thimble::host
