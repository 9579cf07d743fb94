#include "host-tools/files/input_file.h"

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "board/files/text_file.h"
#include "host-tools/error.h"

namespace thimble::host {

std::ifstream open_input(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  const int error = in ? 0 : errno;
  const char* why = in ? board::unreadable_kind(file) : std::strerror(error);
  if (why != nullptr) {
    throw Error(error == EACCES ? ExitCode::kPermission : ExitCode::kBadInput, "cannot-read",
                "cannot read " + file.string() + ": " + why, "check the file's name and rights");
  }
  return in;
}

std::string read_input(const std::filesystem::path& file) {
  std::ifstream in = open_input(file);
  std::optional<std::string> bytes = board::read_bounded(in, kMostInputBytes);
  if (!bytes) {
    throw Error(ExitCode::kBadInput, "too-large",
                file.string() + " has more than " + std::to_string(kMostInputBytes) + " bytes",
                "give a smaller file");
  }
  return std::move(*bytes);
}

}  // namespace thimble::host
