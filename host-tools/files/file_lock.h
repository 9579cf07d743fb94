// One program at a time works with a file that it keeps its progress in.
#pragma once

#include <filesystem>

namespace thimble::host {

// A lock beside `file`, as long as it lives; a program that dies lets it go. Error kPermission or kRefused: the folder cannot be written.
class FileLock {
 public:
  explicit FileLock(const std::filesystem::path& file);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

  [[nodiscard]] bool held() const { return fd_ >= 0; }  // false: another program has it

 private:
  std::filesystem::path lock_;
  int fd_ = -1;
};

}  // namespace thimble::host
