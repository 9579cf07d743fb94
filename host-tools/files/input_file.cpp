#include "host-tools/files/input_file.h"

#include <cerrno>
#include <cstring>
#include <iterator>
#include <system_error>

#include "host-tools/error.h"

namespace thimble::host {

std::ifstream open_input(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  std::error_code none;
  if (!in || std::filesystem::is_directory(file, none)) {
    const int error = in ? EISDIR : errno;
    throw Error(error == EACCES ? ExitCode::kPermission : ExitCode::kBadInput, "cannot-read",
                "cannot read " + file.string() + ": " + std::strerror(error),
                "check the file's name and rights");
  }
  return in;
}

std::string read_input(const std::filesystem::path& file) {
  std::ifstream in = open_input(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace thimble::host
