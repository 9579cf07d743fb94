// drive_session INTERFACE KIND:ID...: the drives of a bus in real time, 1 kHz, on a CAN interface with emulated drives (thimble-sim-drive).
// Prints each change of state, the ages of replies after a second of running, and ends when a drive has a fault: 0, or 1 when it does not run.
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "board/linux/drives/drive_bus.h"
#include "board/linux/drives/open_can_bus.h"
#include "tests/support/drive_configs.h"

namespace {

using namespace thimble::board::drives;
using thimble::test::config_of;

std::uint64_t now_us() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

void sleep_until(std::uint64_t time_us) {
  const timespec until{static_cast<time_t>(time_us / 1'000'000),
                       static_cast<long>(time_us % 1'000'000 * 1000)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

// Until all have answered, at most to end_us.
void collect(DriveBus& bus, std::uint64_t end_us) {
  while (!bus.collect(now_us()) && now_us() < end_us) {
    pollfd waited{bus.descriptor(), POLLIN, 0};
    const timespec at_most{
        0, static_cast<long>(std::max<std::int64_t>(1, static_cast<std::int64_t>(end_us - now_us())) * 1000)};
    ppoll(&waited, 1, &at_most, nullptr);
  }
}

int session(DriveBus& bus, std::size_t drives) {
  const std::vector<float> torque(drives, .02F), damping(drives, .01F);
  std::string last;
  unsigned running = 0;
  std::vector<float> ages;
  const std::uint64_t start_us = now_us();
  for (std::uint64_t tick = 1; tick < 20'000; ++tick) {
    const std::uint64_t begin_us = start_us + 1000 * tick;
    sleep_until(begin_us);
    bus.begin_cycle(now_us(), torque, damping);
    collect(bus, begin_us + 800);
    const auto states = bus.end_cycle(now_us());
    std::string text;
    for (const DriveState& one : states)
      text += std::string(" ") + name_of(one.state) + '/' + name_of(one.fault);
    if (text != last) std::printf("%llu ms:%s\n", static_cast<unsigned long long>(tick), text.c_str());
    last = text;
    if (std::ranges::any_of(states, [](const DriveState& one) { return one.fault != DriveFault::kNone; }))
      return running > 1000 ? 0 : 1;
    if (std::ranges::all_of(states, [](const DriveState& one) { return one.state == State::kIdle; })) {
      for (const Stranger& one : bus.strangers()) std::printf("stranger %x\n", one.id);
      if (!bus.enable().empty()) return 1;
    }
    if (!std::ranges::all_of(states, [](const DriveState& one) { return one.state == State::kRunning; }))
      continue;
    ages.push_back(states[0].age_us);
    if (++running != 1000) continue;
    std::ranges::sort(ages);
    std::printf(
        "running for 1000 ticks; age of replies at the end of a tick, us: median %.0f, most %.0f; late "
        "replies %u\n",
        static_cast<double>(ages[ages.size() / 2]), static_cast<double>(ages.back()), states[0].late_replies);
    std::fflush(stdout);
  }
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<DriveConfig> configs;
  bool fd = false;
  for (int i = 2; i < argc; ++i) {
    const std::string text = argv[i];
    const std::string kind = text.substr(0, text.find(':'));
    for (const Kind one : thimble::test::kKinds)
      if (thimble::test::name_of_kind(one) == kind)
        configs.push_back(
            config_of(one, static_cast<std::uint8_t>(std::stoi(text.substr(text.find(':') + 1)))));
    configs.back().least_reply_us = 0;  // a virtual bus takes no time
    if (configs.back().kind == Kind::kMiniCheetah) configs.back().ranges = {};
    fd = fd || is_fd(configs.back().kind);
  }
  if (const auto wrong = check_drives(configs, thimble::test::kPeriod_s); !wrong.empty()) {
    std::printf("%s\n", std::string(wrong).c_str());
    return 1;
  }
  const std::vector<can_filter> filters = DriveBus({}, configs, thimble::test::kPeriod_s).reply_filters();
  OpenedBus opened = open_can_bus(argv[1], filters, fd);
  if (!opened.socket.is_open()) {
    std::printf("%s\n", opened.trouble.c_str());
    return 1;
  }
  DriveBus bus(std::move(opened.socket), configs, thimble::test::kPeriod_s);
  return session(bus, configs.size());
}
