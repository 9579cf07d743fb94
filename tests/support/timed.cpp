// timed TABLE NAME COMMAND...: runs the command and appends a line to TABLE: NAME, seconds by the clock, seconds of processor time.
//
// ctest starts every test of this machine through it (tests/CMakeLists.txt), and scripts/times prints the table. Processor time includes
// that of all processes the command started. NAME `-` stands for the --gtest_filter of the command; without one, nothing is appended.
// The exit code is that of the command, or 128 + N after signal N.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string_view>

namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

const char* name_of(char** arguments) {
  constexpr std::string_view kFilter = "--gtest_filter=";
  if (std::string_view(arguments[2]) != "-") return arguments[2];
  for (char** argument = arguments + 3; *argument != nullptr; ++argument)
    if (std::string_view(*argument).starts_with(kFilter)) return *argument + kFilter.size();
  return nullptr;
}

[[noreturn]] void run(char** command) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // ctest kills `timed` when the test's time is over
  execvp(command[0], command);
  std::perror(command[0]);
  _exit(127);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: timed TABLE NAME COMMAND...\n");
    return 2;
  }
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // counts what outlives its parent
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) {
    std::perror("fork");
    return 2;
  }
  if (child == 0) run(argv + 3);
  int status = 0;
  for (int ended = 0;;) {
    const pid_t which = wait(&ended);
    if (which == child) status = ended;
    if (which == child || which < 0) break;
  }
  while (waitpid(-1, nullptr, WNOHANG) > 0) continue;
  if (const char* name = name_of(argv)) {
    const std::chrono::duration<double> clock = std::chrono::steady_clock::now() - begin;
    rusage used{};
    getrusage(RUSAGE_CHILDREN, &used);
    std::array<char, 512> line{};
    const int length = std::snprintf(line.data(), line.size(), "%s\t%.2f\t%.2f\n", name, clock.count(),
                                     seconds(used.ru_utime) + seconds(used.ru_stime));
    const int table = open(argv[1], O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
    if (table < 0 || length <= 0 || write(table, line.data(), std::string_view(line.data()).size()) < 0)
      std::perror(argv[1]);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
