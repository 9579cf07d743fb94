// Runs what is missing of a sweep, on several threads. A run has a state of its own, and no random numbers but its seed's: its line does not depend on
// the threads.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host-tools/sweep/sweep_results.h"
#include "host-tools/sweep/sweep_runs.h"

namespace thimble::host {

struct SweepProgress {
  std::size_t done = 0, of = 0;  // runs that were there before are among both
  double left_s = 0;             // 0: not known yet
};

struct SweepTimes {
  bool whole = false;    // false: interrupted
  std::size_t runs = 0;  // that were run
  double wall_s = 0;
  double run_s = 0;  // processor time of all runs
  // What the threads would take if they shared the work exactly, each on a core of its own.
  [[nodiscard]] double ideal_s(std::size_t jobs) const { return run_s / static_cast<double>(jobs); }
};

// One part of several: the runs part, part + parts, part + 2 parts ... (from 0).
struct SweepPart {
  std::size_t part = 0, parts = 1;
};
[[nodiscard]] std::vector<std::size_t> missing_runs(const SweepResults& results, const SweepPart& part);

// results is open. progress: called by this thread, some times a second and after the last run; false: stop. Runs under way are dropped then.
[[nodiscard]] SweepTimes run_sweep(const SweepRuns& runs, SweepResults& results, const SweepPart& part,
                                   std::size_t jobs,
                                   const std::function<bool(const SweepProgress&)>& progress);

}  // namespace thimble::host
