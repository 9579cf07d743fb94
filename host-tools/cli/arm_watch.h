// Disarms the device when this process ends with the arm armed, however it ends: a second process waits for the end of a socket that the
// kernel closes with this one, also after SIGKILL. It opens its own connection, and needs no place among the device's hosts.
#pragma once

#include <sys/types.h>

#include <functional>

#include "host-tools/client/descriptor.h"

namespace thimble::host {

class ArmWatch {
 public:
  // Forks, so: before any thread, and before the device is opened, which may be possible only once. `disarm` is called by the other
  // process, again and again until it does not throw an Error or kArmWatch_us are over.
  explicit ArmWatch(const std::function<void()>& disarm);
  ArmWatch(const ArmWatch&) = delete;
  ArmWatch& operator=(const ArmWatch&) = delete;
  ~ArmWatch();  // waits for the other process

  // Before arming (Error kRefused: nobody watches), and once the arm is disarmed.
  void armed(bool yes);

 private:
  Descriptor end_{-1};
  pid_t watcher_ = -1;
  bool armed_ = false;
};

inline constexpr firmware::link::Micros kArmWatch_us = 5'000'000;

}  // namespace thimble::host
