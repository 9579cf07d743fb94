// One commissioning at a time works with a file of progress.
#pragma once

#include <filesystem>

namespace thimble::host {

// Holds a lock beside `state` as long as it lives; a program that dies lets it go. Throws Error (kRefused, "state-in-use"): another program holds it;
// (kRefused, "cannot-write"): the folder cannot be written.
class StateLock {
 public:
  explicit StateLock(const std::filesystem::path& state);
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;
  ~StateLock();

 private:
  std::filesystem::path file_;
  int fd_ = -1;
};

}  // namespace thimble::host
