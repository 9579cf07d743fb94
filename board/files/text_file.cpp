#include "board/files/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace thimble::board {

std::string read_text(const std::filesystem::path& file) {
  const auto fail = [&file](int error) { throw FileError(file.string() + ": " + std::strerror(error)); };
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) fail(EISDIR);  // it opens, and reads as an empty file
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(errno);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  if (in.bad()) fail(errno);
  return text;
}

}  // namespace thimble::board
