// The files of a sweep: cut short at any byte, in parts, and of another plan.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host-tools/error.h"
#include "host-tools/sweep/sweep_results.h"
#include "tests/support/random.h"
#include "tests/unit/sweep/plans.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using host::Error;
using host::ExitCode;
using host::SweepResults;

const std::string kHead = "# thimble sweep, plan 0123abcd\nrun,seed,status,figure\n";
constexpr std::size_t kColumns = 4, kRuns = 23;

std::string line_of(std::size_t run) {
  return std::to_string(run) + "," + std::to_string(run * run) + ",ok," + std::to_string(1000 / (run + 1));
}
std::string whole_file() {
  std::string text = kHead;
  for (std::size_t run = 0; run < kRuns; ++run) text += line_of(run) + "\n";
  return text;
}

class SweepFiles : public testing::Test {
 protected:
  [[nodiscard]] SweepResults results() const { return {file(), kHead, kColumns, kRuns}; }
  [[nodiscard]] fs::path file() const { return folder_.path() / "out.csv"; }
  [[nodiscard]] fs::path growing(const std::string& part = "") const {
    return folder_.path() / ("out.csv.runs" + part);
  }
  // Runs what is missing, in a random order. Returns how many.
  std::size_t finish() {
    SweepResults now = results();
    now.open("");
    std::size_t run_now = 0;
    for (std::size_t first = random_.below(kRuns), i = 0; i < kRuns; ++i) {
      const std::size_t run = (first + i) % kRuns;
      if (now.has(run)) continue;
      now.add(run, line_of(run));
      ++run_now;
    }
    EXPECT_TRUE(now.is_whole());
    now.finish();
    return run_now;
  }
  std::string error_name(const std::string& part = "") {
    try {
      SweepResults now = results();
      now.open(part);
    } catch (const Error& error) {
      EXPECT_FALSE(error.remedy.empty());
      return error.name;
    }
    return "";
  }

  TemporaryFolder folder_;
  Random random_{18};
};

TEST_F(SweepFiles, AreInTheOrderOfTheRuns) {
  EXPECT_EQ(finish(), kRuns);
  EXPECT_EQ(text_of(file()), whole_file());
  EXPECT_FALSE(fs::exists(growing()));
  EXPECT_TRUE(results().is_whole());
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

// Killed after any byte, nothing that was whole is lost, and nothing is run twice.
TEST_F(SweepFiles, GoOnAfterAnyByte) {
  std::string killed = kHead;
  for (const std::size_t run : {7UL, 0UL, 22UL, 13UL, 3UL}) killed += line_of(run) + "\n";
  for (std::size_t bytes = 0; bytes <= killed.size(); ++bytes) {
    folder_.write("out.csv.runs", killed.substr(0, bytes));
    std::size_t kept = 0;
    for (std::size_t i = kHead.size(); i < bytes; ++i) kept += killed[i] == '\n' ? 1U : 0U;
    ASSERT_EQ(finish(), kRuns - kept) << bytes;
    ASSERT_EQ(text_of(file()), whole_file()) << bytes;
    fs::remove(file());
  }
}

TEST_F(SweepFiles, CollectTheirParts) {
  for (const std::string part : {"1-of-3", "3-of-3"}) {
    SweepResults now = results();
    now.open(part);
    for (std::size_t run = part[0] == '1' ? 0 : 2; run < kRuns; run += 3) now.add(run, line_of(run));
  }
  std::ofstream(growing(".3-of-3"), std::ios::app) << "5,25,o";  // of a task that was killed
  SweepResults before = results();
  EXPECT_EQ(before.done(), 8U + 7U);
  EXPECT_FALSE(before.has(1));
  EXPECT_EQ(finish(), 8U);
  EXPECT_EQ(text_of(file()), whole_file());
  EXPECT_FALSE(fs::exists(growing(".1-of-3")));
}

TEST_F(SweepFiles, LeaveOthersAlone) {
  const std::vector<std::string> others = {".bak",    ".1-of-3.bak", ".1-of-",   ".-of-3",
                                           ".x-of-3", ".1-of-3x",    ".1-of-3-", "1-of-3"};
  for (const std::string& other : others) folder_.write("out.csv.runs" + other, "my own table\n");
  EXPECT_EQ(finish(), kRuns);
  for (const std::string& other : others) EXPECT_TRUE(fs::exists(growing(other))) << other;
}

TEST_F(SweepFiles, SayHowManyRunsFailed) {
  const std::string head =
      "# thimble sweep, plan 0123abcd\nrun,/materials/status/stiffness_N_m,seed,status\n";
  folder_.write("out.csv.runs", head + "0,ok,1,faulted\n2,500,1,ok\n3,500,1,all-stable\n4,500,1,not-armed\n");
  const SweepResults now(file(), head, kColumns, kRuns);
  EXPECT_EQ(now.done(), 4U);
  EXPECT_EQ(now.failed(), 2U);
}

TEST_F(SweepFiles, BelongToOnePlan) {
  folder_.write("out.csv.runs", "# thimble sweep, plan 99999999\nrun,seed,status,figure\n");
  EXPECT_EQ(error_name(), "wrong-results");
  fs::remove(growing());
  folder_.write("out.csv", "my own table\n");
  EXPECT_EQ(error_name(), "wrong-results");
  EXPECT_EQ(text_of(file()), "my own table\n");
}

TEST_F(SweepFiles, DamagedLinesAreNamed) {
  for (const char* line : {"5,25,ok", "23,1,ok,2", "x,1,ok,2", "", "5;25;ok;2", "-1,1,ok,2", "5 ,1,ok,2"}) {
    folder_.write("out.csv.runs", kHead + line_of(2) + "\n" + line + "\n" + line_of(3) + "\n");
    EXPECT_EQ(error_name(), "bad-results") << line;
  }
}

TEST_F(SweepFiles, OneProgramAtATimeAdds) {
  SweepResults first = results();
  first.open("");
  EXPECT_EQ(error_name(), "sweep-in-use");
  EXPECT_EQ(error_name("1-of-2"), "");
}

TEST_F(SweepFiles, AFolderThatIsNotThere) {
  SweepResults lost(folder_.path() / "none" / "out.csv", kHead, kColumns, kRuns);
  EXPECT_THROW(lost.open(""), Error);
}

}  // namespace
}  // namespace thimble::test
