// docs/faults.md and docs/parameters.md are what the tables say. When a table changes, the test leaves the
// new text beside its program and names it; copy it over.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "firmware/faults.h"
#include "firmware/params.h"
#include "firmware/servo.h"

namespace thimble::test {
namespace {

std::string number(float value) {
  char text[32];
  (void)std::snprintf(text, sizeof(text), "%g", static_cast<double>(value));
  return text;
}

std::string faults_page() {
  std::ostringstream page;
  page << "# Faults\n\n"
          "A fault latches: the first reason stays, with the 64 ticks up to it, until `thimble fault clear`. "
          "The motors brake the\n"
          "tip and then let go (reaction \"brakes\"), or let go at once where the tip's velocity can't be "
          "trusted (\"lets go\").\n\n"
          "| number | name | emergency code | reaction | cause | remedy |\n|---|---|---|---|---|---|\n";
  for (const firmware::FaultRow& row : firmware::kFaultTable) {
    char code[8];
    (void)std::snprintf(code, sizeof(code), "0x%04X", static_cast<unsigned>(row.emergency_code));
    page << "| " << static_cast<int>(row.fault) << " | `" << row.name << "` | " << code << " | "
         << (row.reaction == firmware::Reaction::kDamp ? "brakes" : "lets go") << " | " << row.cause << " | "
         << row.remedy << " |\n";
  }
  page << "\n## What can stand against arming, and against a guarded move\n\n| name | remedy |\n|---|---|\n";
  for (const firmware::ConditionRow& row : firmware::kConditionTable)
    page << "| `" << row.name << "` | " << row.remedy << " |\n";
  return page.str();
}

std::string parameters_page() {
  std::ostringstream page;
  page << "# Parameters\n\n"
          "`thimble param` reads and writes them. Values last until power-off. Those that say \"at rest\" "
          "are refused while the motors\n"
          "are on.\n\n"
          "| id | name | unit | default | least | most | may change | meaning "
          "|\n|---|---|---|---|---|---|---|---|\n";
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    char id[8];
    (void)std::snprintf(id, sizeof(id), "0x%04X", static_cast<unsigned>(row.id));
    page << "| " << id << " | `" << row.name << "` | " << row.unit << " | " << number(row.initial) << " | "
         << number(row.min) << " | " << number(row.max) << " | "
         << (row.access == firmware::Access::kAlways ? "always" : "at rest") << " | " << row.text << " |\n";
  }
  return page.str();
}

void compare(const std::string& name, const std::string& expected) {
  const std::filesystem::path page = std::filesystem::path(THIMBLE_SOURCE_DIR) / "docs" / name;
  std::ifstream in(page);
  std::ostringstream found;
  found << in.rdbuf();
  if (found.str() == expected) {
    std::printf("docs/%s: %zu bytes, as the table\n", name.c_str(), expected.size());
    return;
  }
  const std::filesystem::path fresh = std::filesystem::absolute(name);
  std::ofstream(fresh) << expected;
  ADD_FAILURE() << "docs/" << name << " is not what the table says; the right text is in " << fresh;
}

TEST(TablesInDocs, Faults) { compare("faults.md", faults_page()); }
TEST(TablesInDocs, Parameters) { compare("parameters.md", parameters_page()); }

}  // namespace
}  // namespace thimble::test
