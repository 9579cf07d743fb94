#include "host-tools/files/growing_file.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include "host-tools/error.h"

namespace thimble::host {

void GrowingFile::open(const std::filesystem::path& file, std::uintmax_t whole_bytes,
                       const std::string& head) {
  file_ = file;
  if (std::filesystem::exists(file_)) {
    std::error_code failed;
    std::filesystem::resize_file(file_, whole_bytes, failed);
    if (failed) cannot("shorten", failed.value());
  }
  errno = 0;
  stream_.open(file_, std::ios::binary | std::ios::app);
  if (whole_bytes == 0) stream_ << head;
  flush();
}

void GrowingFile::flush() {
  stream_.flush();
  if (!stream_) cannot("write", errno);
}

void GrowingFile::cannot(const char* verb, int error) const {
  throw Error(
      error == EACCES || error == EPERM || error == EROFS ? ExitCode::kPermission : ExitCode::kRefused,
      "cannot-write", std::string("cannot ") + verb + " " + file_.string() + ": " + std::strerror(error),
      "choose a place that you may write to, with space left");
}

}  // namespace thimble::host
