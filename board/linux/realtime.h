// Real-time settings of a Linux thread: locked memory, a touched stack, a high priority, a processor of its
// own. Each function reports what it could not set, and continues.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "board/linux/missing.h"
#include "board/posix/descriptor.h"

namespace thimble::board {

// Locks all present memory of the process, and later memory on first use (so 128 MB of scene slots occupy
// only the size of the scenes).
[[nodiscard]] std::optional<Missing> lock_memory();

// Sets SCHED_FIFO, and the processor if one is given, for the calling thread.
[[nodiscard]] std::vector<Missing> become_realtime(int priority, std::optional<int> cpu);
// Tries the same in a temporary thread and reports what is missing.
[[nodiscard]] std::vector<Missing> try_realtime(int priority, std::optional<int> cpu);

// What the kernel gives beyond that: asked for, reported, and no reason to refuse arming.
class KernelLatency {
 public:
  // Holds cpu_dma_latency at 0 us as long as this lives: no processor sleeps deeper than it wakes at once. `root`: of a system's files, for
  // tests.
  explicit KernelLatency(const std::filesystem::path& root = "/");
  // Sentences for people, one for each: what there is, or what is missing and what to do.
  [[nodiscard]] const std::vector<std::string>& report() const noexcept { return report_; }
  [[nodiscard]] bool preempt_rt() const noexcept { return preempt_rt_; }
  [[nodiscard]] bool awake() const noexcept { return latency_.is_open(); }

 private:
  Descriptor latency_;
  bool preempt_rt_ = false;
  std::vector<std::string> report_;
};

// Touches the stack of the calling thread to the depth that a tick may use.
void prefault_stack() noexcept;
inline constexpr std::size_t kServoStackBytes = std::size_t{1} << 20U;  // for pthread_attr_setstacksize

// Page faults of the calling thread since its start.
[[nodiscard]] long page_faults() noexcept;

}  // namespace thimble::board
