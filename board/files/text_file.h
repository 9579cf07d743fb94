// Text files that are read whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <stdexcept>
#include <string>

namespace thimble::board {

// what(): "file: the system's reason".
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Why `file` is nothing to read, where its kind tells: a directory opens and reads as an empty file, and a device such as /dev/zero may have
// no end. Null: nothing speaks against it.
[[nodiscard]] const char* unreadable_kind(const std::filesystem::path& file);

// Nothing: it is no regular file. A FIFO would wait.
[[nodiscard]] std::optional<std::uintmax_t> size_of_file(const std::filesystem::path& file);

// The bytes of a stream, or nothing where they are more than `most`.
[[nodiscard]] std::optional<std::string> read_bounded(std::istream& in, std::size_t most);

inline constexpr std::size_t kMostTextBytes = std::size_t{1} << 28U;

// Its first bytes, at most this many. Throws FileError as read_text().
[[nodiscard]] std::string read_head(const std::filesystem::path& file, std::size_t most);

// The whole of `file`. Throws FileError if it cannot be read, is a directory or a device, or has more than kMostTextBytes.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);

}  // namespace thimble::board
