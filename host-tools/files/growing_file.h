// A file that grows line by line. Whatever ends the program, its whole lines stay; who reads it again says how many bytes these are.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace thimble::host {

class GrowingFile {
 public:
  // From now on it can be written. whole_bytes: stay of what is in the file, the rest is cut off; 0: head is written first. Error
  // "cannot-write" (kPermission, kRefused), as of flush().
  void open(const std::filesystem::path& file, std::uintmax_t whole_bytes, const std::string& head);
  [[nodiscard]] std::ofstream& stream() { return stream_; }
  void flush();  // the system has what was written, when it returns

 private:
  [[noreturn]] void cannot(const char* verb, int error) const;

  std::filesystem::path file_;
  std::ofstream stream_;
};

}  // namespace thimble::host
