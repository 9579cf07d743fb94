// Sweep plans: what is read, and that all that is wrong is told at once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "host-tools/compiler/scene_errors.h"
#include "host-tools/sweep/sweep_keys.h"
#include "host-tools/sweep/sweep_plan.h"
#include "tests/unit/sweep/plans.h"

namespace thimble::test {
namespace {

using host::Error;
using host::ExitCode;
using host::SceneErrors;
using host::SweepPlan;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kSeeds = R"("vary": [{"what": "seed", "values": [1]}])";

std::vector<std::string> texts(const host::SweepAxis& axis) {
  std::vector<std::string> texts;
  for (const host::SweepValue& value : axis.values) texts.push_back(value.text);
  return texts;
}

TEST(SweepPlanFile, TheLastAxisVariesFastest) {
  const PlanFolder folder;
  const SweepPlan plan = folder.floor(R"("vary": [
    {"what": "arm", "values": ["premium-1.5", "wooden"]},
    {"what": "/materials/wood/stiffness_N_m", "from": 100, "to": 400, "count": 3, "spacing": "ratio"},
    {"what": "/objects/0/material", "values": ["wood", "steel"]}])");
  ASSERT_EQ(plan.runs(), 12U);
  std::size_t run = 0;
  for (std::size_t arm = 0; arm < 2; ++arm)
    for (std::size_t stiffness = 0; stiffness < 3; ++stiffness)
      for (std::size_t material = 0; material < 2; ++material)
        EXPECT_THAT(plan.place(run++), ElementsAre(arm, stiffness, material));
  EXPECT_THAT(texts(plan.axes[1]), ElementsAre("100", "200", "400"));
  EXPECT_THAT(texts(plan.axes[2]), ElementsAre("wood", "steel"));
}

TEST(SweepPlanFile, SeriesEndWhereTheySay) {
  const PlanFolder folder;
  for (const int count : {2, 3, 7, 100}) {
    const SweepPlan plan =
        folder.floor(R"("vary": [{"what": "hand_mass_kg", "from": 0.1, "to": 0.7, "count": )" +
                     std::to_string(count) + "}]");
    ASSERT_EQ(plan.axes[0].values.size(), static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      host::SweepSettings settings;
      plan.axes[0].values[static_cast<std::size_t>(i)].set(settings);
      EXPECT_NEAR(settings.press.hand.mass_kg, .1 + .6 * i / (count - 1), 1e-15);
    }
    EXPECT_EQ(plan.axes[0].values.front().text, "0.1");
    EXPECT_EQ(plan.axes[0].values.back().text, "0.7");
  }
  EXPECT_THAT(texts(folder.floor(R"("vary": [{"what": "seed", "from": 1, "to": 5, "count": 5}])").axes[0]),
              ElementsAre("1", "2", "3", "4", "5"));
}

TEST(SweepPlanFile, ASearchRisesAsFloatsDo) {
  const PlanFolder folder;
  const SweepPlan plan = folder.plan(
      R"({"thimble_sweep": 1, "name": "walls", "wall": true, )" + kSeeds +
      R"(, "largest_stable": {"what": "stiffness_N_m", "from": 100, "to": 100000, "ratio": 1.2}})");
  ASSERT_TRUE(plan.search);
  ASSERT_EQ(plan.search->values.size(), 38U) << "100 * 1.2^37 = 85000";
  float k = 100;
  for (const host::SweepValue& value : plan.search->values) {
    host::SweepSettings settings;
    value.set(settings);
    EXPECT_EQ(settings.press.stiffness_N_m, static_cast<double>(k));
    EXPECT_EQ(std::stof(value.text), k);
    k *= 1.2F;
  }
}

std::vector<host::SceneIssue> issues_of(const PlanFolder& folder, const std::string& text) {
  try {
    static_cast<void>(folder.plan(text));
  } catch (const SceneErrors& errors) {
    EXPECT_EQ(errors.code, ExitCode::kBadInput);
    return errors.issues;
  }
  ADD_FAILURE() << "no error in " << text;
  return {};
}

TEST(SweepPlanFile, AllErrorsAreToldAtOnce) {
  const PlanFolder folder;
  const std::vector<host::SceneIssue> issues = issues_of(folder, R"({
  "thimble_sweep": 1,
  "name": "",
  "scene": "floor.scene.json",
  "path": "press.csv",
  "colour": "red",
  "steady_s": 0.5,
  "set": { "rate_Hz": 50, "speed": 3 },
  "vary": [
    { "what": "sed", "values": [1] },
    { "what": "seed", "values": [1, 1.5, 1] },
    { "what": "seed", "values": [2] },
    { "what": "/materials/wood/stiffness", "values": [1] },
    { "what": "/materials/wood/stiffness_N_m", "values": [100, -1] },
    { "what": "trial", "from": 0, "to": 300, "count": 2, "until": 3 },
    { "what": "arm", "values": ["no-such-arm"] }
  ],
  "table": { "rows": "arm", "columns": "rate_Hz", "value": "force" }
})");
  std::vector<std::string> told;
  for (const host::SceneIssue& issue : issues) {
    told.push_back(std::to_string(issue.place.line) + " " + issue.name);
    EXPECT_FALSE(issue.cause.empty());
    EXPECT_FALSE(issue.remedy.empty()) << issue.cause;
  }
  EXPECT_THAT(told, testing::UnorderedElementsAre("3 bad-value", "6 unknown-key", "7 bad-value",
                                                  "8 bad-value", "8 unknown-value", "10 unknown-value",
                                                  "11 bad-value", "11 repeated-value", "12 repeated-axis",
                                                  "13 unknown-value", "14 bad-value", "15 unknown-key",
                                                  "15 bad-value", "16 unknown-arm", "18 unknown-value"));
}

TEST(SweepPlanFile, EachErrorHasItsName) {
  const PlanFolder folder;
  folder.write(
      "comma.scene.json",
      R"({"thimble_scene": 1, "name": "x", "materials": {"a,b": {"stiffness_N_m": 5}}, "objects": []})");
  folder.write(
      "field.scene.json",
      R"({"thimble_scene": 1, "name": "x", "objects": [{"name": "f", "shape": {"force_field": {"curl_N_s_m": [0, 0, 12], "trial": 1}}}]})");
  const std::string floor =
      R"({"thimble_sweep": 1, "name": "test", "scene": "floor.scene.json", "path": "press.csv", )";
  const std::string wall = R"({"thimble_sweep": 1, "name": "test", "wall": true, )";
  const std::vector<std::array<std::string, 3>> cases = {
      {"[]", "bad-value", "a sweep plan"},
      {"{", "bad-json", ""},
      {R"({"thimble_sweep": 2, "name": 5})", "wrong-version", "reads version 1"},
      {R"({"thimble_sweep": 1, "name": "x", )" + kSeeds + "}", "missing-key", "neither"},
      {floor + R"("wall": true, )" + kSeeds + "}", "bad-value", "no place in a plan of a wall"},
      {floor + R"("vary": []})", "bad-value", "at least 1"},
      {floor + R"("vary": [{"what": "seed", "values": []}]})", "bad-value", "at least 1"},
      {floor + R"("vary": [{"what": "seed"}]})", "missing-key", "from"},
      {floor + R"("vary": [{"what": "seed", "values": [1], "count": 3}]})", "bad-value", "beside"},
      {floor + R"("vary": [{"what": "seed", "from": 1, "to": 2, "count": 2.5}]})", "bad-value", "whole"},
      {floor + R"("vary": [{"what": "seed", "from": 1, "to": 2, "count": 3}]})", "bad-value", "decimals"},
      {floor + R"("vary": [{"what": "hand", "from": 1, "to": 2, "count": 3}]})", "bad-value", "no number"},
      {floor + R"("vary": [{"what": "hand", "values": [{"weight": 1}]}]})", "unknown-key", "weight"},
      {floor + R"("vary": [{"what": "hand", "values": [{"name": "a,b"}]}]})", "bad-value", "commas"},
      {floor + R"("vary": [{"what": "stiffness_N_m", "values": [1]}]})", "unknown-value", "stiffness_N_m"},
      {wall + R"("vary": [{"what": "/objects/0", "values": [1]}]})", "unknown-value", "no scene file"},
      {R"({"thimble_sweep": 1, "name": "x", "scene": "comma.scene.json", "path": "press.csv", "vary": [{"what": "/materials/a,b/stiffness_N_m", "values": [1]}]})",
       "bad-value", "commas"},
      {floor + R"("vary": [{"what": "/objects/0/material", "values": ["glass"]}]})", "unknown-material",
       "refused"},
      {floor +
           R"("vary": [{"what": "seed", "from": 0, "to": 99999, "count": 100000}, {"what": "trial", "from": 0, "to": 19, "count": 20}]})",
       "too-many-runs", "1000000"},
      {floor + R"("set": {"/objects/0/material": "glass"}, )" + kSeeds + "}", "unknown-material",
       "these values"},
      {R"({"thimble_sweep": 1, "name": "x", "scene": "field.scene.json", "path": "press.csv", "vary": [{"what": "/objects/0/shape/force_field/trial", "from": 1, "to": 2, "count": 3}]})",
       "bad-value", "with 1.5"},
      {floor + R"("vary": [{"what": "seed", "values": [1]}, {"what": "rate_Hz", "values": [1000]}],
          "table": {"rows": "seed", "columns": "rate_Hz", "value": "tip_swing_m"}})",
       "no-steady-part", "tip_swing_m"},
      {floor + R"("vary": [{"what": "seed", "values": [1]}, {"what": "rate_Hz", "values": [1000]}],
          "table": {"rows": "seed", "columns": "rate_Hz", "value": "stable"}})",
       "no-steady-part", "stable"},
      {floor + kSeeds + R"(, "largest_stable": {"what": "trial", "from": 1, "to": 8, "ratio": 2}})",
       "no-steady-part", "steady_s"},
      {wall + kSeeds + R"(, "largest_stable": {"what": "seed", "from": 1, "to": 8, "ratio": 2}})",
       "repeated-axis", "seed"},
      {wall + kSeeds + R"(, "largest_stable": {"what": "force_N", "from": 8, "to": 1, "ratio": 2}})",
       "bad-value", "at least"},
      {wall + kSeeds + R"(, "largest_stable": {"what": "force_N", "from": 1, "to": 90, "ratio": 1.001}})",
       "too-many-values", "1000"},
      {wall + kSeeds + R"(, "table": {"rows": "seed", "columns": "seed", "value": "work_J"}})", "bad-value",
       "another axis"},
  };
  for (const std::array<std::string, 3>& each : cases) {
    const std::string &text = each[0], &name = each[1], &cause = each[2];
    const std::vector<host::SceneIssue> issues = issues_of(folder, text);
    const bool has = std::ranges::any_of(issues, [&](const host::SceneIssue& issue) {
      return issue.name == name && issue.cause.find(cause) != std::string::npos && !issue.remedy.empty();
    });
    EXPECT_TRUE(has) << text << "\nis to have " << name << ", " << cause << "; has "
                     << (issues.empty() ? "none" : issues[0].name + ", " + issues[0].cause);
  }
}

TEST(SweepPlanFile, ErrorsOfTheSceneAreItsOwn) {
  const PlanFolder folder;
  folder.write("floor.scene.json",
               R"({"thimble_scene": 1, "name": "x", "objects": [], "size": 2, "colour": 1})");
  try {
    static_cast<void>(folder.floor(kSeeds));
    FAIL();
  } catch (const SceneErrors& errors) {
    EXPECT_EQ(errors.issues.size(), 2U);
    EXPECT_THAT(errors.issues[0].cause, HasSubstr("floor.scene.json:1"));
  }
  const PlanFolder other;
  std::filesystem::remove(other.path() / "press.csv");
  EXPECT_THROW(static_cast<void>(other.floor(kSeeds)), Error);
}

// Results belong to a plan as long as nothing that it depends on has changed.
TEST(SweepPlanFile, TheChecksumCoversEveryFile) {
  const PlanFolder folder;
  const std::uint32_t crc = folder.floor(kSeeds).crc;
  EXPECT_EQ(folder.floor(kSeeds).crc, crc);
  EXPECT_NE(folder.floor(kSeeds + " ").crc, crc);
  folder.write("press.csv", kPressPath + "0.3,0,0,0.001\n");
  EXPECT_NE(folder.floor(kSeeds).crc, crc);
  folder.write("press.csv", kPressPath);
  EXPECT_EQ(folder.floor(kSeeds).crc, crc);
  folder.write("floor.scene.json", kFloorScene + " ");
  EXPECT_NE(folder.floor(kSeeds).crc, crc);
}

std::string tetrahedron(const std::string& size_m) {
  return "v 0 0 0\nv " + size_m + " 0 0\nv 0 " + size_m + " 0\nv 0 0 " + size_m +
         "\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
}

// Also those that only a value names.
TEST(SweepPlanFile, TheChecksumCoversFilesOfValues) {
  const PlanFolder folder;
  folder.write(
      "mesh.scene.json",
      R"({"thimble_scene": 1, "name": "x", "objects": [{"name": "m", "shape": {"mesh": {"file": "a.obj"}}, "material": {"stiffness_N_m": 500}}]})");
  const std::string head =
      R"({"thimble_sweep": 1, "name": "x", "scene": "mesh.scene.json", "path": "press.csv", )";
  const std::string varied =
      head + R"("vary": [{"what": "/objects/0/shape/mesh/file", "values": ["a.obj", "b.obj"]}]})";
  const std::string set = head + R"("set": {"/objects/0/shape/mesh/file": "b.obj"}, )" + kSeeds + "}";
  for (const std::string& text : {varied, set}) {
    folder.write("a.obj", tetrahedron("0.05"));
    folder.write("b.obj", tetrahedron("0.06"));
    const SweepPlan plan = folder.plan(text);
    EXPECT_EQ(std::ranges::count(plan.files, folder.path() / "a.obj"), 1);
    EXPECT_EQ(std::ranges::count(plan.files, folder.path() / "b.obj"), 1);
    EXPECT_EQ(folder.plan(text).crc, plan.crc);
    folder.write("b.obj", tetrahedron("0.07"));
    EXPECT_NE(folder.plan(text).crc, plan.crc);
  }
}

TEST(SweepPlanFile, ATableMayShowWhatIsStable) {
  const PlanFolder folder;
  const SweepPlan plan = folder.floor(
      R"("steady_s": 0.02, "vary": [{"what": "seed", "values": [1]}, {"what": "rate_Hz", "values": [1000]}],
         "table": {"rows": "seed", "columns": "rate_Hz", "value": "stable"})");
  ASSERT_TRUE(plan.table);
  EXPECT_EQ(plan.table->value, "stable");
}

// The page has every key and every value that can be set, with the words of the table.
TEST(SweepPlanFile, ThePageHasEveryKey) {
  const std::string page = text_of(THIMBLE_SOURCE_DIR "/docs/sweep.md");
  int rows = 0;
  for (const host::FileKind& kind : host::sweep_kinds())
    for (const host::FileKey& key : kind.keys) {
      EXPECT_THAT(page, HasSubstr("| `" + std::string(key.name) + "` |")) << kind.name;
      ++rows;
    }
  for (const host::SweepName& name : host::sweep_names()) {
    EXPECT_THAT(page, HasSubstr("| `" + std::string(name.name) + "` |"));
    ++rows;
  }
  for (const host::MeasureColumn& column : host::measure_columns())
    EXPECT_THAT(page, HasSubstr("| `" + std::string(column.name) + "` |"));
  EXPECT_GT(rows, 40);
}

}  // namespace
}  // namespace thimble::test
