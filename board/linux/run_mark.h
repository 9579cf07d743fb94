// Whether the last run of the board's program ended in order, in a file that the service manager keeps until the machine restarts
// (RuntimeDirectory=). Without such a folder nothing is known.
#pragma once

#include <filesystem>

namespace thimble::board {

class RunMark {
 public:
  enum class Before : unsigned char { kNoRun, kEnded, kCrashed };  // since the machine has started

  // An empty folder: there is none, and before() is kNoRun. Throws std::system_error if the folder cannot be written.
  explicit RunMark(const std::filesystem::path& folder);
  RunMark(const RunMark&) = delete;
  RunMark& operator=(const RunMark&) = delete;
  ~RunMark();  // the end in order, also after an exception

  [[nodiscard]] Before before() const noexcept { return before_; }

 private:
  std::filesystem::path file_;
  Before before_ = Before::kNoRun;
};

}  // namespace thimble::board
