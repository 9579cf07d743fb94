// Text files that are read whole.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace thimble::board {

// what(): "file: the system's reason".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The whole of `file`. Throws FileError if it cannot be read or is a directory.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);

}  // namespace thimble::board
