#include "board/linux/guardian.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "board/linux/clock.h"
#include "board/linux/realtime.h"

namespace thimble::board {
namespace {

// Waits for at most this long; true: the board has ended.
bool ended_within(int pipe, std::uint64_t wait_ns) noexcept {
  pollfd entry{pipe, 0, 0};  // POLLHUP is always reported
  const timespec wait{static_cast<time_t>(wait_ns / 1'000'000'000U),
                      static_cast<long>(wait_ns % 1'000'000'000U)};
  return ppoll(&entry, 1, &wait, nullptr) > 0;
}

// With every drive off it looks once in a limit, which is soon enough for a drive that is switched on
// meanwhile.
void watch(int pipe, const std::function<void()>& make_safe, ServoBeat& beat) {
  std::uint64_t wait_ns = 0;
  while (!ended_within(pipe, wait_ns)) {
    wait_ns = Guardian::kLimit_ns;
    const std::uint64_t last_ns = beat.last_ns(), now_ns = monotonic_ns();
    if (last_ns == 0) continue;
    if (now_ns < last_ns + Guardian::kLimit_ns) {
      wait_ns = last_ns + Guardian::kLimit_ns - now_ns;
      continue;
    }
    beat.cut_drives();
    make_safe();
    beat.cut_drives();  // a servo that called off() meanwhile may have switched a drive on again
  }
  make_safe();
}

}  // namespace

Guardian::Guardian(const std::function<void()>& make_safe, ServoBeat& beat, int priority) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  const Descriptor reading(ends[0]);
  pipe_ = Descriptor(ends[1]);
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::generic_category(), "fork the guardian");
  if (process_ > 0) return;

  pipe_ = Descriptor();  // otherwise the pipe would never close
  sigset_t all;
  sigfillset(&all);
  // A service manager that ends the board also sends its signal here, too early.
  sigprocmask(SIG_SETMASK, &all, nullptr);
  prctl(PR_SET_NAME, "thimble-guard");
  (void)lock_memory();  // the board reports what is missing: it tries the same
  (void)become_realtime(priority, std::nullopt);
  watch(reading.get(), make_safe, beat);
  _exit(0);
}

Guardian::~Guardian() {
  pipe_ = Descriptor();
  if (process_ < 0) return;
  kill(process_, SIGCONT);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool Guardian::gone() noexcept {
  int status = 0;
  if (process_ > 0 && waitpid(process_, &status, WNOHANG | WUNTRACED) == process_) {
    stopped_ = WIFSTOPPED(status);
    if (!stopped_) process_ = -1;
  }
  return stopped_ || process_ < 0;
}

}  // namespace thimble::board
