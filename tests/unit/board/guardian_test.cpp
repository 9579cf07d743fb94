// The guardian makes the outputs safe in whatever way the board process ends, stops or hangs.
#include "board/linux/guardian.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "board/linux/clock.h"

namespace thimble::test {
namespace {

using board::Descriptor;
using board::Guardian;
using board::monotonic_ns;
using board::ServoBeat;

constexpr int kGuardianPriority = 81;
constexpr int kPatience_ms = 10'000;  // for an event on a busy machine

// SafeOutputs that write into a pipe when they were made safe.
struct SafeOutputs {
  SafeOutputs() {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    reading = Descriptor(ends[0]);
    writing = Descriptor(ends[1]);
  }
  void make_safe() const {
    const std::uint64_t now_ns = monotonic_ns();
    EXPECT_EQ(write(writing.get(), &now_ns, sizeof(now_ns)), ssize_t{sizeof(now_ns)});
  }
  // How often they were made safe, once everybody who could has ended.
  int count() {
    writing = Descriptor();
    int times = 0;
    for (std::uint64_t at_ns = 0; read(reading.get(), &at_ns, sizeof(at_ns)) == ssize_t{sizeof(at_ns)};)
      ++times;
    return times;
  }
  bool silent_for(int ms) const {
    pollfd entry{reading.get(), POLLIN, 0};
    return poll(&entry, 1, ms) == 0;
  }
  // When they were made safe next; 0: not in time.
  std::uint64_t next_ns() const {
    std::uint64_t at_ns = 0;
    if (silent_for(kPatience_ms) || read(reading.get(), &at_ns, sizeof(at_ns)) != ssize_t{sizeof(at_ns)})
      return 0;
    return at_ns;
  }
  Descriptor reading, writing;
};

void sleep_us(long us) {
  const timespec time{0, us * 1000};
  nanosleep(&time, nullptr);
}

enum class FakeServo : std::uint8_t { kDrivesOff, kDrives, kHangs };

// A board with this servo, running. A servo that hangs has driven 20 times before.
pid_t start_board(const SafeOutputs& outputs, ServoBeat& beat, FakeServo servo) {
  const pid_t board = fork();
  if (board == 0) {
    signal(SIGSEGV, SIG_DFL);  // the sanitizers would make an exit of it
    const Guardian guardian([&outputs] { outputs.make_safe(); }, beat, kGuardianPriority);
    raise(SIGSTOP);
    for (int tick = 0;; ++tick) {
      if (servo == FakeServo::kDrives || (servo == FakeServo::kHangs && tick < 20))
        beat.driving(monotonic_ns());
      sleep_us(500);
    }
  }
  int status = 0;
  EXPECT_EQ(waitpid(board, &status, WUNTRACED), board);
  EXPECT_TRUE(WIFSTOPPED(status));
  kill(board, SIGCONT);
  return board;
}

void end_board(pid_t board, int signal) {
  kill(board, signal);
  int status = 0;
  ASSERT_EQ(waitpid(board, &status, 0), board);
  EXPECT_TRUE(WIFSIGNALED(status));
}

// From the last outputs of a servo that stands to the safe state. The guardian of a test may lack the privilege
// for its priority, so the upper bound is a wide one. On a busy machine the servo of a test may be late before
// it stands, and the guardian acts then, too.
void expect_prompt(const SafeOutputs& outputs, const ServoBeat& beat, const char* what) {
  std::uint64_t safe_ns = 0, last_ns = 0;
  do {
    safe_ns = outputs.next_ns();
    ASSERT_NE(safe_ns, 0U) << "nothing was made safe";
    sleep_us(20'000);
    last_ns = beat.last_ns();
  } while (safe_ns < last_ns);
  const double latency_ms = static_cast<double>(safe_ns - last_ns) * 1e-6;
  std::printf("[ figure ] %s: drives off %.2f ms after the servo's last outputs\n", what, latency_ms);
  EXPECT_GE(latency_ms, 5.0);
  EXPECT_LE(latency_ms, 1000.0);
}

TEST(Guardian, ActsWhenTheBoardIsKilled) {
  for (const int signal : {SIGKILL, SIGSEGV, SIGTERM}) {
    SafeOutputs outputs;
    const ServoBeat::Shared beat = ServoBeat::make();
    const pid_t board = start_board(outputs, *beat, FakeServo::kDrivesOff);
    EXPECT_TRUE(outputs.silent_for(50)) << "it acted while the board was there";
    end_board(board, signal);
    EXPECT_EQ(outputs.count(), 1) << "signal " << signal;
  }
}

TEST(Guardian, ActsWhenTheBoardIsStopped) {
  const SafeOutputs outputs;
  const ServoBeat::Shared beat = ServoBeat::make();
  const pid_t board = start_board(outputs, *beat, FakeServo::kDrives);
  while (beat->last_ns() == 0) sleep_us(100);
  kill(board, SIGSTOP);
  expect_prompt(outputs, *beat, "stopped");
  EXPECT_TRUE(beat->cut());
  EXPECT_NE(outputs.next_ns(), 0U) << "it acts once only";
  kill(board, SIGCONT);
  EXPECT_TRUE(beat->cut()) << "a servo that resumes has to find it";
  end_board(board, SIGKILL);
}

TEST(Guardian, ActsWhenTheServoHangs) {
  const SafeOutputs outputs;
  const ServoBeat::Shared beat = ServoBeat::make();
  const pid_t board = start_board(outputs, *beat, FakeServo::kHangs);
  expect_prompt(outputs, *beat, "hung");
  EXPECT_TRUE(beat->cut());
  end_board(board, SIGKILL);
}

TEST(Guardian, LeavesAStoppedBoardWithoutDrivesAlone) {
  SafeOutputs outputs;
  const ServoBeat::Shared beat = ServoBeat::make();
  const pid_t board = start_board(outputs, *beat, FakeServo::kDrivesOff);
  kill(board, SIGSTOP);
  EXPECT_TRUE(outputs.silent_for(100));
  EXPECT_FALSE(beat->cut());
  end_board(board, SIGKILL);
  EXPECT_EQ(outputs.count(), 1);
}

TEST(Guardian, ActsAtAnOrderlyEnd) {
  SafeOutputs outputs;
  const ServoBeat::Shared beat = ServoBeat::make();
  {
    Guardian guardian([&outputs] { outputs.make_safe(); }, *beat, kGuardianPriority);
    EXPECT_FALSE(guardian.gone());
  }
  EXPECT_FALSE(outputs.silent_for(0));  // before the destructor returned
  EXPECT_EQ(outputs.count(), 1);
}

// The guardian's process is the only child of this one; 0: there is none.
pid_t only_child() {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream in(entry.path() / "stat");
    std::string text;
    std::getline(in, text);
    char state = 0;
    pid_t parent = 0;
    const std::size_t name_end = text.rfind(')');
    if (name_end == std::string::npos) continue;
    std::istringstream(text.substr(name_end + 1)) >> state >> parent;
    if (parent == getpid() && state != 'Z') return std::stoi(entry.path().filename());
  }
  return 0;
}

TEST(Guardian, IsGoneWhenItIsEndedOrStopped) {
  for (const int signal : {SIGKILL, SIGSTOP}) {
    const SafeOutputs outputs;
    const ServoBeat::Shared beat = ServoBeat::make();
    Guardian guardian([&outputs] { outputs.make_safe(); }, *beat, kGuardianPriority);
    const pid_t child = only_child();
    ASSERT_GT(child, 0);
    EXPECT_FALSE(guardian.gone());
    kill(child, signal);
    for (int tries = 0; tries < kPatience_ms && !guardian.gone(); ++tries) sleep_us(1000);
    EXPECT_TRUE(guardian.gone()) << "signal " << signal;
  }
}

}  // namespace
}  // namespace thimble::test
