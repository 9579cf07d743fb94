// A temporary file or folder that SIGINT, SIGTERM and SIGHUP remove before they end the program. A verb that handles these signals itself
// ends in order, and removes what it made. One thread.
#pragma once

#include <cstddef>
#include <filesystem>

namespace thimble::host {

class RemovedOnSignal {
 public:
  explicit RemovedOnSignal(const std::filesystem::path& path);  // the folder before the files in it
  RemovedOnSignal(const RemovedOnSignal&) = delete;
  RemovedOnSignal& operator=(const RemovedOnSignal&) = delete;
  ~RemovedOnSignal() { forget(); }

  void forget();  // it stays

 private:
  std::size_t place_;
};

}  // namespace thimble::host
