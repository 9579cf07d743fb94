// The tables of docs/commissioning.md, and the faults that `--fault` takes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/commission/planted.h"
#include "host-tools/commission/steps.h"
#include "host-tools/error.h"
#include "tests/support/generated_docs.h"

namespace thimble::host {
namespace {

TEST(CommissionDocs, HaveTheSteps) {
  std::string rows = "| step | name | what it proves |\n|---|---|---|";
  for (const Step& step : steps())
    fmt::format_to(std::back_inserter(rows), "\n| {} | {} | {} |", step.number, step.name, step.text);
  test::expect_generated("docs/commissioning.md", "steps", rows);
}

TEST(CommissionDocs, HaveTheFaults) {
  std::string rows = "| name | planted | what | what to do |\n|---|---|---|---|";
  for (const FaultText& text : fault_texts()) {
    const auto planted = std::ranges::find(planted_faults(), text.fault, &PlantedFault::fault);
    std::string how;
    if (planted != planted_faults().end()) {
      how = text.fault == ArmFault::kLineIgnored ? "yes" : planted->exchanges ? "`@AXIS,AXIS`" : "`@AXIS`";
      if (planted->factor != 0)
        how = fmt::format("`@AXIS:FACTOR`, {}; {} to {}", planted->factor, planted->least, planted->most);
    }
    fmt::format_to(std::back_inserter(rows), "\n| `{}` | {} | {} | {} |", text.name, how, text.what,
                   text.remedy);
  }
  test::expect_generated("docs/commissioning.md", "faults", rows);
}

ArmFile arm_of(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

TEST(PlantedFault, IsReadFromWords) {
  ArmFile arm = arm_of("touch");
  const std::string first = arm.axes[0].name, second = arm.axes[1].name;
  const SimFault sign = planted_fault("motor-sign@" + second, arm);
  EXPECT_EQ(sign.fault, ArmFault::kMotorSign);
  EXPECT_EQ(sign.axis, 1U);
  const SimFault weak = planted_fault("weak-motor@" + first + ":0.5", arm);
  EXPECT_EQ(weak.axis, 0U);
  EXPECT_EQ(weak.factor, .5);
  const SimFault swapped = planted_fault("motors-swapped@" + second + "," + first, arm);
  EXPECT_EQ(swapped.axis, 1U);
  EXPECT_EQ(swapped.other, 0U);
  EXPECT_EQ(planted_fault("line-ignored", arm).fault, ArmFault::kLineIgnored);
  arm.axes[0].name = "a:2";  // a name with what a factor begins with
  EXPECT_EQ(planted_fault("encoder-sign@a:2", arm).axis, 0U);
  EXPECT_EQ(planted_fault("wrong-counts@a:2:4", arm).factor, 4);
}

TEST(PlantedFault, RefusesWhatIsNone) {
  const ArmFile arm = arm_of("touch");
  const std::string driven = arm.axes[0].name, sensed = arm.axes[5].name;
  struct Case {
    std::string text, name;
  };
  const std::array cases{Case{"", "unknown-fault"},
                         Case{"motor", "unknown-fault"},
                         Case{"feeds-energy@" + driven, "unknown-fault"},
                         Case{"motor-sign", "bad-fault"},
                         Case{"motor-sign@nobody", "unknown-axis"},
                         Case{"motor-sign@" + sensed, "bad-fault"},
                         Case{"motor-sign@" + driven + ":2", "bad-fault"},
                         Case{"weak-motor@" + driven + ":nan", "bad-fault"},
                         Case{"weak-motor@" + driven + ":0", "bad-fault"},
                         Case{"weak-motor@" + driven + ":1x", "bad-fault"},
                         Case{"wrong-counts@" + driven + ":1", "bad-fault"},
                         Case{"index-off@" + driven + ":0.5", "bad-fault"},
                         Case{"motors-swapped@" + driven, "bad-fault"},
                         Case{"motors-swapped@" + driven + "," + driven, "bad-fault"},
                         Case{"line-ignored@" + driven, "bad-fault"}};
  for (const Case& one : cases) {
    try {
      static_cast<void>(planted_fault(one.text, arm));
      ADD_FAILURE() << one.text;
    } catch (const Error& error) {
      EXPECT_EQ(error.name, one.name) << one.text;
      EXPECT_EQ(error.code, ExitCode::kUsage) << one.text;
      EXPECT_FALSE(error.remedy.empty());
    }
  }
}

}  // namespace
}  // namespace thimble::host
