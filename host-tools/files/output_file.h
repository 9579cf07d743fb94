// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <span>

#include "host-tools/files/removed_on_signal.h"

namespace thimble::host {

// Throws "same-file" (kUsage) where the output of a verb is a file that it reads.
void keep_apart(const std::filesystem::path& input, const std::filesystem::path& output);
void keep_apart(std::span<const std::filesystem::path> inputs, const std::filesystem::path& output);
// The same where two outputs of a verb are one file; either may be "": none.
void keep_outputs_apart(const std::filesystem::path& one, const std::filesystem::path& other);

// A file that is written under a temporary name beside its final path and renamed by commit(); without commit() it is removed, also by a
// signal that ends the program. It has the permissions of the file that it replaces, and replaces what a symbolic link names. A path that
// exists and is no regular file (a pipe, /dev/stdout) is written directly. Errors: kPermission, kRefused (no space ...).
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path place);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  [[nodiscard]] std::ofstream& stream() { return stream_; }
  void flush();
  // Keeps the temporary file without commit(), because its content is of use even if incomplete.
  void keep_draft() {
    kept_ = true;
    removed_.reset();
  }
  void commit();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path place_;
  std::filesystem::path draft_;
  std::ofstream stream_;
  std::optional<RemovedOnSignal> removed_;
  bool kept_ = false;
};

}  // namespace thimble::host
