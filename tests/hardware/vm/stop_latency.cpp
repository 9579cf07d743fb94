// stop_latency FILE TEXT: writes TEXT to a file ("pull-down" to a simulated GPIO line, "FROZEN" to a freezer) while a board drives the
// converter of arm_hardware/. stop_latency PROCESS STOP: sends SIGSTOP instead. Prints as JSON after how many loads of the converter, and how long, its voltages have left what they were.
// In the virtual machine only; exit code 1: they never did.
#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/hardware/vm/arm_hardware.h"

namespace {

using thimble::test::ConverterOutputs;
using thimble::test::now_ns;

constexpr timespec kLook{0, 100'000};  // ten looks a tick
constexpr int kLooks = 10'000;         // a second
constexpr int kChange =
    1000;  // steps of the converter: 0.3 V, 0.15 A; a tick's change in steady contact is a tenth

bool zero(const ConverterOutputs& a) { return a.word[0] == 0 && a.word[1] == 0 && a.word[2] == 0; }

int change(const ConverterOutputs& a, const ConverterOutputs& b) {
  int most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::abs(a.word[i] - b.word[i]));
  return most;
}

}  // namespace

int main(int argc, char** argv) {
  const int hardware = open("/dev/arm_hardware", O_RDONLY), file = argc == 3 ? open(argv[1], O_WRONLY) : -1;
  const bool stops = argc == 3 && std::strcmp(argv[2], "STOP") == 0;
  ConverterOutputs before{}, now{};
  if (hardware < 0 || (file < 0 && !stops) || read(hardware, &before, sizeof(before)) != sizeof(before))
    return 1;
  int steady = 0;  // how much the voltages change by themselves
  for (int look = 0; look < 200; ++look) {
    nanosleep(&kLook, nullptr);
    if (read(hardware, &now, sizeof(now)) != sizeof(now)) return 1;
    steady = std::max(steady, change(before, now));
    before = now;
  }
  const std::uint64_t edge_ns = now_ns();
  if (stops ? kill(static_cast<pid_t>(std::strtol(argv[1], nullptr, 10)), SIGSTOP) != 0
            : write(file, argv[2], std::strlen(argv[2])) < 0)
    return 1;
  for (int look = 0; look < kLooks; ++look) {
    if (read(hardware, &now, sizeof(now)) != sizeof(now)) return 1;
    if (change(before, now) > kChange || zero(now)) {
      std::printf("{\"loads\": %u, \"latency_us\": %.0f, \"steady_steps\": %d, \"step\": %d}\n",
                  now.loads - before.loads, static_cast<double>(now.last_load_ns - edge_ns) * 1e-3, steady,
                  change(before, now));
      return 0;
    }
    nanosleep(&kLook, nullptr);
  }
  std::printf("{\"loads\": %u, \"steady_steps\": %d, \"step\": %d}\n", now.loads - before.loads, steady,
              change(before, now));
  return 1;
}
