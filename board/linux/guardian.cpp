#include "board/linux/guardian.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace thimble::board {

bool Guardian::begin() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  Descriptor reading(ends[0]);
  pipe_ = Descriptor(ends[1]);
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::generic_category(), "fork the guardian");
  if (process_ > 0) return false;

  pipe_ = Descriptor();  // otherwise the pipe would never close
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_SETMASK, &all,
              nullptr);  // a service manager that ends the board also sends its signal here, too early
  prctl(PR_SET_NAME, "thimble-guard");
  char byte = 0;
  while (::read(reading.get(), &byte, 1) < 0 && errno == EINTR) {
  }
  return true;
}

void Guardian::leave() noexcept { _exit(0); }

Guardian::~Guardian() {
  pipe_ = Descriptor();
  if (process_ > 0)
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

bool Guardian::gone() noexcept {
  if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) == process_) process_ = -1;
  return process_ < 0;
}

}  // namespace thimble::board
