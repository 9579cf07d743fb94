// docs/drives.md: the table of faults is that of drive_faults.def, the tests that it names exist, and no trap's test is missing from it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

#include "tests/support/generated_docs.h"

namespace thimble::test {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(DriveDocs, FaultsAreThoseOfTheTable) {
  std::string rows = "| fault | meaning |\n|---|---|";
#define DRIVE_FAULT(enumerator, name, sentence) \
  rows += std::string("\n| `") + (name) + "` | " + (sentence) + " |";
#include "board/linux/drives/drive_faults.def"
#undef DRIVE_FAULT
  expect_generated("docs/drives.md", "faults", rows);
}

TEST(DriveDocs, EveryTrapHasItsTestAndEveryTestIsNamed) {
  const std::filesystem::path top = THIMBLE_SOURCE_DIR;
  const std::string page = text_of(top / "docs/drives.md");
  std::set<std::string> tests;
  for (const auto& entry : std::filesystem::directory_iterator(top / "tests/unit/drives")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = text_of(entry.path());
    static const std::regex kTest("TEST(?:_P)?\\((\\w+),\\s+(\\w+)\\)");
    for (std::sregex_iterator at(text.begin(), text.end(), kTest), end; at != end; ++at)
      tests.insert((*at)[1].str() + '.' + (*at)[2].str());
  }
  std::set<std::string> named;
  static const std::regex kName("`([A-Z]\\w+\\.[A-Z]\\w+)`");
  for (std::sregex_iterator at(page.begin(), page.end(), kName), end; at != end; ++at) {
    named.insert((*at)[1]);
    EXPECT_TRUE(tests.contains((*at)[1])) << "no test is named " << (*at)[1];
  }
  for (const std::string& test : tests)
    if (test.starts_with("DriveTraps.")) {
      EXPECT_TRUE(named.contains(test)) << test;
    }
}

}  // namespace
}  // namespace thimble::test
