// How the last run ended, and when the time of day is known.
#include "board/linux/run_mark.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>

#include "board/linux/wall_clock.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using board::RunMark;

TEST(RunMark, TellsAnEndInOrderFromACrash) {
  const TemporaryFolder folder;
  EXPECT_EQ(RunMark(folder.path()).before(), RunMark::Before::kNoRun);
  EXPECT_EQ(RunMark(folder.path()).before(), RunMark::Before::kEnded);
  try {
    const RunMark mark(folder.path());
    throw std::runtime_error("an adapter is missing");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(RunMark(folder.path()).before(), RunMark::Before::kEnded);
  const pid_t child = fork();
  if (child == 0) {
    const RunMark mark(folder.path());
    (void)kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(RunMark(folder.path()).before(), RunMark::Before::kCrashed);
  EXPECT_EQ(RunMark(folder.path()).before(), RunMark::Before::kEnded);
}

TEST(RunMark, KnowsNothingWithoutAFolder) {
  EXPECT_EQ(RunMark("").before(), RunMark::Before::kNoRun);
  EXPECT_EQ(RunMark("").before(), RunMark::Before::kNoRun);
}

TEST(WallClock, IsKnownWithARealTimeClockOrATimeServer) {
  const TemporaryFolder folder;
  EXPECT_EQ(board::wall_clock_s(folder.path()), 0U);
  const std::filesystem::path rtc = folder.path() / "sys/class/rtc/rtc0";
  std::filesystem::create_directories(rtc);
  std::ofstream(rtc / "hctosys") << "0\n";
  EXPECT_EQ(board::wall_clock_s(folder.path()), 0U);
  std::ofstream(rtc / "hctosys") << "1\n";
  EXPECT_GT(board::wall_clock_s(folder.path()), 1700000000U);
  std::ofstream(rtc / "hctosys") << "0\n";
  const std::filesystem::path sync = folder.path() / "run/systemd/timesync";
  std::filesystem::create_directories(sync);
  std::ofstream(sync / "synchronized") << "";
  EXPECT_GT(board::wall_clock_s(folder.path()), 1700000000U);
}

}  // namespace
}  // namespace thimble::test
