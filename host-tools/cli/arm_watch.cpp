#include "host-tools/cli/arm_watch.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>

#include "host-tools/client/transport.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr useconds_t kTryAgain_us = 50'000;

// What the watched process says to the one that watches. If it says no more, it was killed: getppid() proves nothing, for the socket
// ends before the kernel gives the process another parent.
enum class Word : char { kDisarmed, kArmed, kArmedAndReports };

// The other process: until the socket ends, then once more for the device.
void watch(int end, const std::function<void()>& disarm) {
  setsid();  // what a terminal or a group of processes is sent ends this one's parent only
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) std::signal(one, SIG_IGN);
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  Word last = Word::kDisarmed;
  while (recv(end, &last, 1, 0) > 0) {
  }
  if (last == Word::kDisarmed) return;
  const auto say = [last](const std::string& text) {
    if (last == Word::kArmed) fmt::print(stderr, "{}", text);
  };
  std::string failure;
  for (const link::Micros give_up_us = now_us() + kArmWatch_us; now_us() < give_up_us; usleep(kTryAgain_us)) {
    try {
      disarm();
      say("thimble: killed while the arm was armed: it was disarmed\n");
      return;
    } catch (const Error& error) {
      failure = error.cause;
    }
  }
  say("thimble: not-disarmed: killed while the arm was armed: " + failure +
      "\n  remedy: `thimble stop`, or the e-stop button\n");
}

bool tell(int end, Word word) { return send(end, &word, sizeof word, MSG_NOSIGNAL) == sizeof word; }

}  // namespace

ArmWatch::ArmWatch(const std::function<void()>& disarm) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) == 0) {
    end_ = Descriptor(ends[0]);
    watcher_ = fork();
    if (watcher_ == 0) {
      close(ends[0]);
      try {
        watch(ends[1], disarm);
      } catch (...) {
        _exit(1);
      }
      _exit(0);
    }
    close(ends[1]);
  }
  if (watcher_ < 0) {
    throw Error(ExitCode::kRefused, "no-watch",
                std::string("no process can be started that disarms: ") + std::strerror(errno),
                "end other programs");
  }
}

ArmWatch::~ArmWatch() {
  if (armed_) tell(end_.get(), Word::kArmedAndReports);
  end_ = Descriptor(-1);
  while (waitpid(watcher_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void ArmWatch::armed(bool yes) {
  armed_ = yes;
  if (tell(end_.get(), yes ? Word::kArmed : Word::kDisarmed) || !yes) return;
  throw Error(ExitCode::kRefused, "no-watch", "the process that disarms if this one is killed has ended",
              "repeat the command");
}

}  // namespace thimble::host
