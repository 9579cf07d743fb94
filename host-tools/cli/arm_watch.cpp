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

// The other process: until the socket ends, then once more for the device.
void watch(int end, const std::function<void()>& disarm) {
  const pid_t parent = getppid();
  const auto say = [parent](const std::string& text) {
    if (getppid() != parent) fmt::print(stderr, "{}", text);  // else it reports itself
  };
  setsid();  // what a terminal or a group of processes is sent ends this one's parent only
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) std::signal(one, SIG_IGN);
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  char armed = 0;
  while (recv(end, &armed, 1, 0) > 0) {
  }
  if (armed == 0) return;
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
  end_ = Descriptor(-1);
  while (waitpid(watcher_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void ArmWatch::armed(bool yes) {
  const char byte = yes ? 1 : 0;
  if (send(end_.get(), &byte, 1, MSG_NOSIGNAL) == 1 || !yes) return;
  throw Error(ExitCode::kRefused, "no-watch", "the process that disarms if this one is killed has ended",
              "repeat the command");
}

}  // namespace thimble::host
