#include "host-tools/cli/state_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

// The one before may have removed the file between open and lock: then this is a lock of nothing.
bool is_still_there(int fd, const std::filesystem::path& file) {
  struct stat held {
  }, there{};
  return fstat(fd, &held) == 0 && stat(file.c_str(), &there) == 0 && held.st_ino == there.st_ino &&
         held.st_dev == there.st_dev;
}

}  // namespace

StateLock::StateLock(const std::filesystem::path& state)
    : file_(state.parent_path() / fmt::format(".{}.lock", state.filename().string())) {
  constexpr unsigned kMode = 0644;
  for (;;) {
    fd_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
    const bool forbidden = errno == EACCES || errno == EPERM || errno == EROFS;
    if (fd_ < 0)
      throw Error(forbidden ? ExitCode::kPermission : ExitCode::kRefused,
                  forbidden ? "permission" : "cannot-write",
                  fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)),
                  "check the folder, or give another file with --state");
    if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      close(fd_);
      throw Error(ExitCode::kRefused, "state-in-use",
                  fmt::format("another commissioning works with {}", state.string()),
                  "wait until it has ended, or give another file with --state");
    }
    if (is_still_there(fd_, file_)) return;
    close(fd_);
  }
}

StateLock::~StateLock() {
  unlink(file_.c_str());
  close(fd_);
}

}  // namespace thimble::host
