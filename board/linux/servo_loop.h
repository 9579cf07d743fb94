// The servo context on Linux: one thread that sleeps until an absolute time, reads the devices, calls Controller::tick() and
// writes the devices, once a period. In a tick it makes the system calls of its devices, one to sleep, and no other; it
// touches no memory that is not there.
#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <future>
#include <optional>
#include <vector>

#include "board/common/liveness.h"
#include "board/linux/missing.h"
#include "board/linux/tick_devices.h"
#include "firmware/controller.h"

namespace thimble::board {

enum LivenessContext : std::size_t { kTick, kLink, kBackground, kLivenessContexts };
using BoardLiveness = Liveness<kLivenessContexts>;

class ServoLoop {
 public:
  struct Options {
    double rate_Hz = 1000;
    int priority = 80;
    std::optional<int> cpu;
  };
  struct Report {  // of the ticks since start()
    std::uint64_t ticks = 0;
    std::uint64_t lost = 0;  // periods
    float worst_late_us = 0;
    long page_faults = 0;
  };

  ServoLoop(const Options& options, TickDevices& devices, BoardLiveness& liveness);
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;
  ~ServoLoop() { (void)stop(); }

  // Starts the thread; the controller must outlive it. Returns when the first tick is about to begin, with what the thread
  // could not have; the controller was made with what try_realtime() said before. Throws std::system_error when there can be
  // no thread.
  [[nodiscard]] std::vector<Missing> start(firmware::Controller& controller);
  // Ends the thread after the tick under way, and makes the devices safe. Without a thread nothing.
  Report stop();

 private:
  static void* run_thread(void* self);
  void run();
  void tick(std::uint64_t number, std::uint64_t due_ns);

  Options options_;
  std::uint64_t period_ns_;
  TickDevices& devices_;
  BoardLiveness& liveness_;
  firmware::Controller* controller_ = nullptr;
  std::optional<pthread_t> thread_;
  std::promise<std::vector<Missing>> started_;
  std::atomic<bool> stopping_{false};
  firmware::Inputs in_;
  Report report_;
};

}  // namespace thimble::board
