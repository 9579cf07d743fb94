#include "board/files/text_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace thimble::board {

const char* unreadable_kind(const std::filesystem::path& file) {
  std::error_code none;
  const std::filesystem::file_status status = std::filesystem::status(file, none);
  if (is_directory(status)) return "Is a directory";
  return is_character_file(status) || is_block_file(status) ? "Is a device, not a file" : nullptr;
}

std::optional<std::string> read_bounded(std::istream& in, std::size_t most) {
  std::string bytes;
  std::array<char, 65536> part{};
  while (in.read(part.data(), part.size()) || in.gcount() != 0) {
    bytes.append(part.data(), static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > most) return std::nullopt;
  }
  return bytes;
}

std::string read_text(const std::filesystem::path& file) {
  const auto fail = [&file](const char* why) { throw FileError(file.string() + ": " + why); };
  if (const char* why = unreadable_kind(file)) fail(why);
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(std::strerror(errno));
  std::optional<std::string> text = read_bounded(in, kMostTextBytes);
  if (in.bad()) fail(std::strerror(errno));
  if (!text) fail(std::strerror(EFBIG));
  return std::move(*text);
}

}  // namespace thimble::board
