// A sweep as a job array of Slurm: this machine submits, waits and collects.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

namespace thimble::host {

struct SlurmArray {
  std::filesystem::path plan, output;  // on a file system that all nodes see
  std::size_t tasks = 1;
  std::size_t jobs = 1;  // processors of each task
};

// Submits `thimble sweep PLAN --output OUT --array I/N` for each task, and waits until all have ended. go_on: asked some times a second; false: the
// job is cancelled. What the tasks print is in OUTPUT.slurm.I. Error kNotFound: there is no Slurm; kRefused: it refuses the job.
void run_in_slurm(const SlurmArray& array, const std::function<bool()>& go_on);

}  // namespace thimble::host
