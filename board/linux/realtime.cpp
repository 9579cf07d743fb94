#include "board/linux/realtime.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <utility>

namespace thimble::board {
namespace {

constexpr std::size_t kPrefaultedBytes = std::size_t{256}
                                         << 10U;  // tests/unit/board measures what a tick takes
constexpr std::size_t kPageBytes = 4096;

Missing missing(const char* name, const std::string& what, const std::string& remedy) {
  return {name, what + ": " + std::strerror(errno), remedy, errno};
}

// A small process may fit into a low limit although its slots and threads do not.
bool room_for_more() noexcept {
  constexpr std::size_t kBytes = std::size_t{256} << 20U;
  void* map =
      mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return map != MAP_FAILED && munmap(map, kBytes) == 0;
}

}  // namespace

std::optional<Missing> lock_memory() {
  // Two calls: MCL_ONFAULT with MCL_CURRENT would not load present pages that were never touched.
  if (mlockall(MCL_CURRENT) == 0 && mlockall(MCL_FUTURE | MCL_ONFAULT) == 0 && room_for_more())
    return std::nullopt;
  Missing refused = missing("no_locked_memory", "lock memory (memlock)",
                            "run under the systemd unit, or set LimitMEMLOCK=infinity (ulimit -l unlimited)");
  refused.error = EPERM;  // a limit that is too low gives ENOMEM or EAGAIN
  munlockall();
  return refused;
}

std::vector<Missing> become_realtime(int priority, std::optional<int> cpu) {
  std::vector<Missing> all;
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) != 0)
    all.push_back(missing("no_realtime_priority",
                          "real-time priority " + std::to_string(priority) + " (rtprio)",
                          "run under the systemd unit, or set LimitRTPRIO=" + std::to_string(priority) +
                              " (ulimit -r " + std::to_string(priority) + ")"));
  if (cpu) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(*cpu), &set);
    if (sched_setaffinity(0, sizeof(set), &set) != 0)
      all.push_back(missing("no_processor", "processor " + std::to_string(*cpu),
                            "correct /realtime/cpu in the configuration"));
  }
  return all;
}

std::vector<Missing> try_realtime(int priority, std::optional<int> cpu) {
  std::vector<Missing> missing;
  std::thread([&] { missing = become_realtime(priority, cpu); }).join();
  return missing;
}

KernelLatency::KernelLatency(const std::filesystem::path& root) {
  std::ifstream file(root / "sys/kernel/realtime");
  int value = 0;
  preempt_rt_ = (file >> value) && value == 1;
  report_.emplace_back(
      preempt_rt_
          ? "the kernel has PREEMPT_RT"
          : "the kernel has no PREEMPT_RT: under load it wakes the servo late by milliseconds; install "
            "linux-image-rt-*");
  const std::filesystem::path device = root / "dev/cpu_dma_latency";
  Descriptor opened(open(device.c_str(), O_WRONLY | O_CLOEXEC));
  constexpr std::int32_t kNone_us = 0;
  if (opened.is_open() && write(opened.get(), &kNone_us, sizeof(kNone_us)) == ssize_t{sizeof(kNone_us)}) {
    latency_ = std::move(opened);
    report_.emplace_back("cpu_dma_latency is held at 0 us");
  } else {
    report_.push_back(device.string() + ": " + std::strerror(errno) +
                      ": the processors may sleep deeply, and wake the servo late; install the udev rule");
  }
}

void prefault_stack() noexcept {
  std::array<unsigned char, kPrefaultedBytes> stack;
  auto* bytes = static_cast<volatile unsigned char*>(stack.data());
  for (std::size_t i = 0; i < stack.size(); i += kPageBytes) bytes[i] = 0;
}

long page_faults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace thimble::board
