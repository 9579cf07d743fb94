// The servo context on Linux: one thread that sleeps until an absolute time, reads the devices, calls
// Controller::tick() and writes the devices, once a period. A tick makes only the system calls of its devices
// and one to sleep, and causes no page fault.
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
  struct Report {  // ticks since start()
    std::uint64_t ticks = 0;
    std::uint64_t lost = 0;  // periods
    float worst_late_us = 0;
    long page_faults = 0;
  };

  ServoLoop(const Options& options, TickDevices& devices, BoardLiveness& liveness);
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;
  ~ServoLoop() { (void)stop(); }

  // Starts the thread; the controller must outlive it. Returns before the first tick, with the real-time
  // settings that the thread could not get (the controller was configured with the result of try_realtime()).
  // Throws std::system_error if the thread cannot be started.
  [[nodiscard]] std::vector<Missing> start(firmware::Controller& controller);
  // Ends the thread after the current tick and makes the devices safe. Without a thread it does nothing.
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
