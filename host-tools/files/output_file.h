// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <fstream>

namespace thimble::host {

// A file that is written beside its place and moved there by commit(); without it nothing remains. A place
// that exists and is no regular file (a pipe, /dev/stdout) is written directly. Errors: kPermission, kRefused
// (no space ...).
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path place);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  [[nodiscard]] std::ofstream& stream() { return stream_; }
  void flush();
  // What is written is of use by itself: without commit() it stays beside its place.
  void keep_draft() { kept_ = true; }
  void commit();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path place_;
  std::filesystem::path draft_;
  std::ofstream stream_;
  bool kept_ = false;
};

}  // namespace thimble::host
