// docs/faults.md and docs/parameters.md are generated from the tables. If a page differs from its table, the test writes the
// correct page to the current folder and prints its path; copy it to docs/.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "firmware/core/core.h"
#include "firmware/core/faults.h"
#include "firmware/params.h"

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
          "A fault latches: the first reason and the 64 ticks up to it are kept until `thimble fault clear`. "
          "Reaction \"brakes\": the motors\n"
          "damp the tip before they go off. Reaction \"off\": they go off at once, because the tip velocity "
          "cannot be trusted.\n\n"
          "| number | name | emergency code | reaction | cause | remedy |\n|---|---|---|---|---|---|\n";
  for (const firmware::FaultRow& row : firmware::kFaultTable) {
    char code[8];
    (void)std::snprintf(code, sizeof(code), "0x%04X", static_cast<unsigned>(row.emergency_code));
    page << "| " << static_cast<int>(row.fault) << " | `" << row.name << "` | " << code << " | "
         << (row.reaction == firmware::Reaction::kDamp ? "brakes" : "off") << " | " << row.cause << " | "
         << row.remedy << " |\n";
  }
  page << "\n## Conditions for arming and for guarded moves\n\nA refused command reports every unmet "
          "condition "
          "by name.\n\n| name | remedy |\n|---|---|\n";
  for (const firmware::ConditionRow& row : firmware::kConditionTable)
    page << "| `" << row.name << "` | " << row.remedy << " |\n";
  return page.str();
}

std::string parameters_page() {
  std::ostringstream page;
  page << "# Parameters\n\n"
          "`thimble param` reads and writes them. Values last until power-off unless `thimble param save` "
          "stores "
          "them (column \"saved\").\n"
          "Parameters that may change \"at rest\" are refused while the motors are on. A recording ends "
          "before a "
          "parameter with \"yes\" in the\n"
          "column \"recorded\" is written, because it has an effect on the forces. One with \"marks\" is "
          "taken "
          "by one tick, which the host is told\nand a recording keeps "
          "([recording.md](recording.md#events-and-trials)).\n\n"
          "| id | name | unit | default | minimum | maximum | may change | saved | recorded | meaning "
          "|\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    char id[8];
    (void)std::snprintf(id, sizeof(id), "0x%04X", static_cast<unsigned>(row.id));
    page << "| " << id << " | `" << row.name << "` | " << row.unit << " | " << number(row.initial) << " | "
         << number(row.min) << " | " << number(row.max) << " | "
         << (row.access == firmware::Access::kAlways ? "always" : "at rest") << " | "
         << (row.persistent == firmware::Persistence::kPersistent ? "yes" : "no") << " | "
         << (marks(row)                                       ? "marks"
             : row.recorded == firmware::Recording::kRecorded ? "yes"
                                                              : "no")
         << " | " << row.text << " |\n";
  }
  return page.str();
}

void compare(const std::string& name, const std::string& expected) {
  const std::filesystem::path page = std::filesystem::path(THIMBLE_SOURCE_DIR) / "docs" / name;
  std::ifstream in(page);
  std::ostringstream found;
  found << in.rdbuf();
  if (found.str() == expected) {
    std::printf("docs/%s: %zu bytes, equal to the table\n", name.c_str(), expected.size());
    return;
  }
  const std::filesystem::path fresh = std::filesystem::absolute(name);
  std::ofstream(fresh) << expected;
  ADD_FAILURE() << "docs/" << name << " differs from its table; the correct page is " << fresh;
}

TEST(TablesInDocs, Faults) { compare("faults.md", faults_page()); }
TEST(TablesInDocs, Parameters) { compare("parameters.md", parameters_page()); }

}  // namespace
}  // namespace thimble::test
