#include "board/linux/servo_loop.h"

#include <signal.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include "board/linux/clock.h"
#include "board/linux/realtime.h"

namespace thimble::board {
namespace {

constexpr std::uint64_t kNs = 1'000'000'000;

void sleep_until(std::uint64_t time_ns) noexcept {
  const timespec time{static_cast<time_t>(time_ns / kNs), static_cast<long>(time_ns % kNs)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

void check(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

}  // namespace

ServoLoop::ServoLoop(const Options& options, TickDevices& devices, BoardLiveness& liveness)
    : options_(options),
      period_ns_(static_cast<std::uint64_t>(std::llround(1e9 / options.rate_Hz))),
      devices_(devices),
      liveness_(liveness) {}

std::vector<Missing> ServoLoop::start(firmware::Controller& controller) {
  controller_ = &controller;
  started_ = {};
  stopping_ = false;
  report_ = {};
  in_ = {};
  pthread_attr_t attributes{};
  check(pthread_attr_init(&attributes), "thread attributes");
  check(pthread_attr_setstacksize(&attributes, kServoStackBytes), "servo stack");
  // The main thread handles signals.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, &run_thread, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  check(error, "servo thread");
  thread_ = thread;
  return started_.get_future().get();
}

ServoLoop::Report ServoLoop::stop() {
  if (!thread_) return report_;
  stopping_ = true;
  pthread_join(*thread_, nullptr);
  thread_.reset();
  return report_;
}

void* ServoLoop::run_thread(void* self) {
  static_cast<ServoLoop*>(self)->run();
  return nullptr;
}

void ServoLoop::run() {
  pthread_setname_np(pthread_self(), "thimble-servo");
  prefault_stack();
  started_.set_value(become_realtime(options_.priority, options_.cpu));

  const std::uint64_t begin_ns = monotonic_ns();
  const long faults_before = page_faults();
  std::uint64_t next = 0;  // number of the tick that is due
  while (!stopping_.load(std::memory_order_relaxed)) {
    sleep_until(begin_ns + next * period_ns_);
    // After a delay of whole periods, the ticks in between are lost.
    const std::uint64_t number = std::max(next, (monotonic_ns() - begin_ns) / period_ns_);
    report_.lost += number - next;
    tick(number, begin_ns + next * period_ns_);
    next = number + 1;
  }
  report_.page_faults = page_faults() - faults_before;
  devices_.make_safe();
}

void ServoLoop::tick(std::uint64_t number, std::uint64_t due_ns) {
  const std::uint64_t begin_ns = monotonic_ns();
  in_.late_us = static_cast<float>(begin_ns - due_ns) * 1e-3F;
  report_.worst_late_us = std::max(report_.worst_late_us, in_.late_us);
  ++report_.ticks;
  in_.tick = number;
  in_.time_us = begin_ns / 1000;
  devices_.read(in_, begin_ns, period_ns_);
  devices_.write(controller_->tick(in_));
  in_.last_tick_us = static_cast<float>(monotonic_ns() - begin_ns) * 1e-3F;
  liveness_.beat(kTick);
}

}  // namespace thimble::board
