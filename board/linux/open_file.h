// Opens a file or throws, with the path in the message.
#pragma once

#include <fcntl.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "board/posix/descriptor.h"

namespace thimble::board {

// mode: permissions of a new file. Throws std::system_error.
[[nodiscard]] inline Descriptor open_file(const std::filesystem::path& path, int flags, mode_t mode = 0644) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), path.string());
  return Descriptor(fd);
}

}  // namespace thimble::board
