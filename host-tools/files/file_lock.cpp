#include "host-tools/files/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

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

FileLock::FileLock(const std::filesystem::path& file)
    : lock_(file.parent_path() / std::string(".").append(file.filename().string()).append(".lock")) {
  constexpr unsigned kMode = 0644;
  for (;;) {
    fd_ = open(lock_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
    const bool forbidden = errno == EACCES || errno == EPERM || errno == EROFS;
    if (fd_ < 0)
      throw Error(forbidden ? ExitCode::kPermission : ExitCode::kRefused,
                  forbidden ? "permission" : "cannot-write",
                  "cannot write " + lock_.string() + ": " + std::strerror(errno),
                  "check the folder, or give another file");
    const bool mine = flock(fd_, LOCK_EX | LOCK_NB) == 0;
    if (mine && is_still_there(fd_, lock_)) return;
    close(fd_);
    fd_ = -1;
    if (!mine) return;
  }
}

FileLock::~FileLock() {
  if (!held()) return;
  unlink(lock_.c_str());
  close(fd_);
}

}  // namespace thimble::host
