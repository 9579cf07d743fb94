// The guardian makes the outputs safe in whatever way the board process ends.
#include "board/linux/guardian.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

namespace thimble::test {
namespace {

using board::Descriptor;
using board::Guardian;

// Outputs whose safe state is a byte in a pipe.
struct PipedOutputs {
  int fd;
  void make_safe() const { EXPECT_EQ(write(fd, "S", 1), 1); }
};

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    reading = Descriptor(ends[0]);
    writing = Descriptor(ends[1]);
  }
  // How often the outputs were made safe, once everybody who could has ended.
  int count() {
    writing = Descriptor();
    int bytes = 0;
    for (char byte = 0; read(reading.get(), &byte, 1) == 1;) ++bytes;
    return bytes;
  }
  bool silent_for(int ms) const {
    pollfd entry{reading.get(), POLLIN, 0};
    return poll(&entry, 1, ms) == 0;
  }
  Descriptor reading, writing;
};

// A board that waits for its end.
pid_t start_board(const Pipe& pipe) {
  const pid_t board = fork();
  if (board == 0) {
    signal(SIGSEGV, SIG_DFL);  // the sanitizers would make an exit of it
    PipedOutputs outputs{pipe.writing.get()};
    const Guardian guardian(outputs);
    raise(SIGSTOP);
    while (true) pause();
  }
  int status = 0;
  EXPECT_EQ(waitpid(board, &status, WUNTRACED), board);
  EXPECT_TRUE(WIFSTOPPED(status));
  kill(board, SIGCONT);
  return board;
}

TEST(Guardian, ActsWhenTheBoardIsKilled) {
  for (const int signal : {SIGKILL, SIGSEGV, SIGTERM}) {
    Pipe pipe;
    const pid_t board = start_board(pipe);
    EXPECT_TRUE(pipe.silent_for(50)) << "it acted while the board was there";
    kill(board, signal);
    int status = 0;
    ASSERT_EQ(waitpid(board, &status, 0), board);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(pipe.count(), 1) << "signal " << signal;
  }
}

TEST(Guardian, ActsAtAnOrderlyEnd) {
  Pipe pipe;
  PipedOutputs outputs{pipe.writing.get()};
  {
    Guardian guardian(outputs);
    EXPECT_FALSE(guardian.gone());
  }
  EXPECT_FALSE(pipe.silent_for(0));  // before the destructor returned
  EXPECT_EQ(pipe.count(), 1);
}

}  // namespace
}  // namespace thimble::test
